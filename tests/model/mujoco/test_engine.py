"""Steps of MuJoCo against closed forms and an integration of Drake's accelerations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aerodrake.model.mujoco.engine import INTEGRATORS, MujocoEngine
from aerodrake.model.vehicle.rotation import product
from aerodrake.model.vehicle.state import VehicleState, split_state
from tests.mujoco_vehicles import PERIOD_S, BothEngines, Forces


def no_forces(both: BothEngines) -> Forces:
    n, k = both.vehicle.joints, len(both.vehicle.rotors.spin)
    return Forces(np.zeros(k), np.zeros(n), np.zeros(6 + n))


def with_integrator(both: BothEngines, integrator: str, substeps: int = 1) -> MujocoEngine:
    return MujocoEngine(both.engine.model, PERIOD_S, integrator, substeps)


def flown(engine: MujocoEngine, x: np.ndarray, forces: Forces, steps: int) -> np.ndarray:
    for _ in range(steps):
        x = engine.step(x, *forces)
    return x


def integrated(both: BothEngines, x: np.ndarray, forces: Forces, seconds: float) -> np.ndarray:
    """Returns the state after an integration of Drake's accelerations, to 1e-11."""
    n = both.vehicle.joints

    def derivative(_: float, x: np.ndarray) -> np.ndarray:
        state = split_state(x)
        rate = product(np.concatenate([[0.0], state.omega_W]), state.quaternion) / 2
        positions = np.concatenate([rate, state.v_B, state.qdot])
        return np.concatenate([positions, both.drake_accelerations(x, forces)])

    x = solve_ivp(derivative, (0, seconds), x, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    x[:4] /= np.linalg.norm(x[:4])
    assert len(x) == VehicleState.size(n)
    return x


def test_free_fall(packaged):
    """The joints stay at rest, since all bodies fall alike. Euler's velocities are exact, and its
    positions are half a step too low per second."""
    start = VehicleState.at_rest([1.0, 2.0, 50.0], packaged.vehicle.working, (0.3, -0.2, 2.0))
    start = start._replace(v_B=np.array([1.0, -2.0, 3.0]))
    for integrator in INTEGRATORS:
        engine, seconds = with_integrator(packaged, integrator), 0.4
        end = split_state(flown(engine, start.to_vector(), no_forces(packaged), 400))
        fall = 9.81 * seconds * (seconds + (0.0 if integrator == "rk4" else PERIOD_S)) / 2
        expected = start.p_B + seconds * start.v_B - [0, 0, fall]
        np.testing.assert_allclose(end.p_B, expected, atol=1e-9)
        np.testing.assert_allclose(end.v_B, start.v_B - [0, 0, 9.81 * seconds], atol=1e-9)
        np.testing.assert_allclose(end.q, start.q, atol=1e-9)
        np.testing.assert_allclose(end.quaternion, start.quaternion, atol=1e-9)


def test_torque_about_the_base_changes_the_angular_momentum_alone(both):
    """The torque is fixed in the world, whatever the attitude: L = L_0 + tau t about the centre of
    mass, which falls freely."""
    plant, forces = both.plant, no_forces(both)
    forces.force[:3] = [0.5, -0.3, 0.2]
    x = both.random_state(np.random.default_rng(2))

    def motion(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        context = plant.CreateDefaultContext()
        plant.SetPositionsAndVelocities(context, x)
        centre = plant.CalcCenterOfMassPositionInWorld(context)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, centre)
        return momentum.rotational(), momentum.translational()

    end = flown(both.engine, x, forces, 100)
    (L_0, P_0), (L, P) = motion(x), motion(end)
    np.testing.assert_allclose(L - L_0, 0.1 * forces.force[:3], atol=1e-9)
    weight = 9.81 * plant.CalcTotalMass(plant.CreateDefaultContext())
    np.testing.assert_allclose(P - P_0, [0, 0, -0.1 * weight], atol=1e-9)


def test_runge_kutta_has_the_forces_of_each_stage(both):
    """Thrusts turn with the base, the generalized force does not. With forces of the step's start
    the error would be 1e-6."""
    rng = np.random.default_rng(3)
    x, forces = both.random_state(rng), both.random_forces(rng)
    end, expected = flown(both.engine, x, forces, 20), integrated(both, x, forces, 0.02)
    end[:4] *= np.sign(end[:4] @ expected[:4])
    np.testing.assert_allclose(end, expected, atol=2e-9)


def test_order_of_integrators_and_substeps(packaged):
    """Halving Euler's time step halves the error."""
    rng = np.random.default_rng(4)
    x, forces = packaged.random_state(rng), packaged.random_forces(rng)
    expected = integrated(packaged, x, forces, 0.02)

    def error(integrator: str, substeps: int) -> float:
        end = flown(with_integrator(packaged, integrator, substeps), x, forces, 20)
        return float(np.abs(end - expected).max())

    for integrator in ("euler", "implicitfast"):
        assert error(integrator, 2) == pytest.approx(error(integrator, 1) / 2, rel=0.1)
    assert error("rk4", 1) < 1e-4 * error("implicitfast", 1)


def test_results_depend_on_the_arguments_alone(packaged):
    """A landing, where a warm start of the contact solver would remember the step before."""
    forces = no_forces(packaged)
    start = packaged.vehicle.trim_state
    start[6] = -packaged.vehicle.feet_m + 0.001
    states = [start]
    for _ in range(60):
        states.append(packaged.engine.step(states[-1], *forces))
    assert packaged.engine.data.ncon == 4
    again = with_integrator(packaged, "rk4")
    for before, after in reversed(list(zip(states, states[1:], strict=False))):
        np.testing.assert_array_equal(again.step(before, *forces), after)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_stays_so(value, packaged, tmp_path, monkeypatch, capfd):
    """MuJoCo would reset the state, take thrusts for zero, and write a file into the working
    directory."""
    monkeypatch.chdir(tmp_path)
    x, forces = packaged.vehicle.trim_state, no_forces(packaged)
    arguments = [x, *forces]
    for i, argument in enumerate(arguments):
        changed = argument.copy()
        changed[-1] = value
        end = packaged.engine.step(*arguments[:i], changed, *arguments[i + 1 :])
        assert not np.isfinite(packaged.engine.step(end, *forces)).all()
    assert np.isfinite(packaged.engine.step(x, *forces)).all()
    assert not list(tmp_path.iterdir())
    assert not "".join(capfd.readouterr())

"""Tracking cost: J_6 against its definition, from model states and numerical rotations."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.objective import limited_gain
from aerodrake.model.mpc.tick import MpcInputs, Pointing
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Mpc, Scenario

UP, G = np.array([0.0, 0.0, 1.0]), 9.81
CONFIG = Mpc(horizon=6, span_ticks=14, w_6=70.0, k_o=4.0, approach_speed_rad_s=50.0)
YAW_RATE, XI_U_RATES = 0.03, np.array([0.04, -0.02])


@pytest.fixture(scope="module")
def kinematics(vehicle) -> Kinematics:
    return Kinematics(vehicle.plant)


@pytest.fixture(scope="module")
def model(scenario, vehicle) -> EquivalentModel:
    return EquivalentModel.of(Scenario(), vehicle.joints)


@pytest.fixture(scope="module")
def state(vehicle) -> VehicleState:
    """State near trim, tilted and yawed."""
    x = vehicle.trim_state + 0.1 * np.random.default_rng(1).normal(size=len(vehicle.trim_state))
    x[:4] /= np.linalg.norm(x[:4])
    return split_state(x)


@pytest.fixture(scope="module")
def tick(model, kinematics, state) -> MpcInputs:
    rng = np.random.default_rng(2)
    N = CONFIG.horizon
    d = kinematics.tool_axis(state).value + 0.05 * rng.normal(size=(N + 1, 3))
    return MpcInputs(
        x_0=0.05 * rng.normal(size=len(model.A)),
        u_last=np.zeros(model.B.shape[1]),
        end_effector=kinematics.end_effector(state),
        rpy_rates=np.array([*XI_U_RATES, YAW_RATE]),
        reference=np.zeros((N + 1, 6)),
        delta=0.01 * rng.normal(size=3),
        w_q=1.0,
        w_m=1.0,
        w_d=1.0,
        pointing=Pointing(
            kinematics.tool_axis(state), np.hstack([d, 0.1 * rng.normal(size=(N + 1, 3))])
        ),
    )


def formulation(config, model, vehicle) -> MpcFormulation:
    return MpcFormulation(config, model, vehicle)


def tool_direction(kinematics, state, by=(0.0, 0.0, 0.0), q=0.0) -> np.ndarray:
    """Returns the tool direction (3,) after a small rotation of the base and a motion of q."""
    t_B, _ = kinematics.arm_axis(state.q + q)
    return Rotation.from_rotvec(by).apply(state.R_B @ t_B)


def derivative(change, size: int, h: float = 1e-6) -> np.ndarray:
    """Returns the central difference quotients (3, size) at zero."""
    steps = h * np.eye(size)
    return np.column_stack([(change(s) - change(-s)) / (2 * h) for s in steps])


def j_6(config, model, kinematics, state, tick, ticks, U) -> float:
    """Returns J_6, summed over the stages, with states of the model and numerical Jacobians."""
    by_q = derivative(lambda q: tool_direction(kinematics, state, q=q), model.joints)
    # A base acceleration a turns the base by z x a / g.
    by_a = derivative(lambda a: tool_direction(kinematics, state, by=np.cross(UP, a) / G), 3)
    _, pitch, yaw = state.rpy
    spin = YAW_RATE * UP
    if config.tilt == "held":
        roll_axis = Rotation.from_euler("ZY", [yaw, pitch]).apply([1, 0, 0])
        pitch_axis = Rotation.from_euler("z", yaw).apply([0, 1, 0])
        spin = spin + XI_U_RATES @ [roll_axis, pitch_axis]
    if config.tilt != "flatness":
        by_a = 0 * by_a
    t_0 = tool_direction(kinematics, state)
    x, cost = tick.x_0, 0.0
    for k, (stage, u) in enumerate(zip(ticks, U, strict=True), start=1):
        before = model.acceleration @ x
        for _ in range(stage):
            x = model.predict(x, u, tick.delta)
        a = model.acceleration @ x
        t = (
            t_0
            + by_q @ (x - tick.x_0)[model.joint_position]
            + by_a @ (a - model.acceleration @ tick.x_0)
        )
        rate = (
            by_q @ x[model.joint_velocity]
            + np.cross(spin, t_0)
            + by_a @ (a - before) / (stage * model.dt)
        )
        d, d_rate = np.split(tick.pointing.reference[k], 2)
        if config.error == "frozen":
            t, d = t_0, tick.pointing.reference[0, :3]
        residual = rate - d_rate + config.k_o * (t - d)
        cost += stage * config.w_6 * residual @ residual
    return cost


@pytest.mark.parametrize(
    ("error", "tilt"),
    [("predicted", "flatness"), ("predicted", "held"), ("frozen", "none"), ("frozen", "flatness")],
)
def test_the_orientation_task_adds_only_j_6(error, tilt, model, vehicle, kinematics, state, tick):
    config = dataclasses.replace(CONFIG, error=error, tilt=tilt)
    ours = formulation(config, model, vehicle)
    program, without = ours.form(tick), ours.form(dataclasses.replace(tick, pointing=None))
    H, g = program.H - without.H, program.g - without.g
    np.testing.assert_array_equal(program.lower, without.lower)
    np.testing.assert_array_equal(program.upper, without.upper)
    rng = np.random.default_rng(3)

    def expected(z: np.ndarray) -> float:
        return j_6(config, model, kinematics, state, tick, ours.stage_ticks, ours.inputs(z))

    for z in rng.uniform(-1, 1, (5, len(ours.scale))):
        # The program is half of the sum of squares, up to a constant.
        value = 2 * (z @ H @ z / 2 + g @ z)
        assert value == pytest.approx(expected(z) - expected(0 * z), rel=1e-6, abs=1e-6)


def test_rotation_about_the_tool_axis_is_free(model, vehicle, tick):
    """The axis of the last joint is the tool axis."""
    ours = formulation(CONFIG, model, vehicle)
    H = ours.form(tick).H - ours.form(dataclasses.replace(tick, pointing=None)).H
    np.testing.assert_allclose(H[-CONFIG.horizon :], 0, atol=1e-9)
    assert np.abs(H).max() > 1e-3


def test_gain_is_limited_by_the_approach_speed():
    gain, error = np.full(3, 4.0), np.array([0.0, 0.3, 0.4])
    np.testing.assert_allclose(limited_gain(gain, error, 0.5), 1.0)
    np.testing.assert_array_equal(limited_gain(gain, error, 5.0), gain)
    np.testing.assert_array_equal(limited_gain(gain, 0 * error, 0.5), gain)

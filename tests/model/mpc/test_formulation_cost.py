"""The condensed cost against the cost summed in a simulation of the model."""

import dataclasses

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.scenario import Model, Mpc, Scenario

K_B, DT = (1.8, 2.5, 6.67), 0.02
UP, G = np.array([0.0, 0.0, 1.0]), 9.81
CONFIG = Mpc(
    horizon=8,
    k_e=(3.0, 2.0, 4.0),
    w_1=(1e4, 2e4, 0.5e4),
    w_2_base=(1e-2, 2e-2, 3e-2),
    w_2_joints=(1e-2, 2e-2, 1e-3, 3e-2, 2e-3, 1e-2),
    w_3_base=(30.0, 20.0, 40.0),
    w_3_joints=(10.0, 12.0, 8.0, 15.0, 9.0, 11.0),
    w_4=(300.0, 200.0, 400.0),
    w_5=(3.0, 20.0, 150.0),
)


def weighted_square(weights: tuple[float, ...], x: np.ndarray) -> float:
    return np.dot(weights, x**2)


def cost(config: Mpc, model: EquivalentModel, tick: MpcInputs, p_O, u: np.ndarray) -> float:
    """Returns the cost of inputs u (N, 3 + n), constant over their stages."""
    at, K_e, tilts = tick.end_effector, np.array(config.k_e), config.tilt == "flatness"
    p_0, q_0 = tick.x_0[model.base_position], tick.x_0[model.joint_position]

    def tilted(x: np.ndarray) -> np.ndarray:
        """Returns the displacement of the end-effector by the tilt of the base."""
        v_d, v = x[model.setpoint_velocity], x[model.base_velocity]
        if not tilts:
            return np.zeros(3)
        a = x[model.base_state("b")] if "b" in model.axis_states else np.multiply(K_B, v_d - v)
        return np.cross(np.cross(UP, a) / G, at.r)

    total, x, u_last = 0.0, tick.x_0, tick.u_last
    for k, ticks in enumerate(stage_ticks(config)):
        before = tilted(x)
        for _ in range(ticks):
            x = model.predict(x, u[k], tick.delta)
        v, qdot = x[model.base_velocity], x[model.joint_velocity]
        q = x[model.joint_position]
        turned = at.J_c[:, 3] * tick.rpy_rates[2] + (tilted(x) - before) / (ticks * DT)
        if config.tilt == "held":
            turned = turned + at.J_u @ tick.rpy_rates[:2]
        p_Ed, v_Ed = tick.reference[k + 1, :3], tick.reference[k + 1, 3:]
        moved = x[model.base_position] - p_0 + at.J_c[:, 4:] @ (q - q_0)
        e = at.p_E + moved + tilted(x) - tilted(tick.x_0) - p_Ed
        if config.error == "frozen":
            e = at.p_E - tick.reference[0, :3]
        J_1 = weighted_square(config.w_1, v + at.J_c[:, 4:] @ qdot + turned - v_Ed + K_e * e)
        J_2 = tick.w_q * weighted_square(config.w_2_base, v)
        J_2 += tick.w_m * weighted_square(config.w_2_joints, qdot)
        J_3 = weighted_square(config.w_3_base + config.w_3_joints, u[k])
        J_4 = tick.w_d * weighted_square(config.w_4, at.p_EB + at.J_B @ (q - q_0) - p_O)
        J_5 = weighted_square(config.w_5, u[k][:3] - u_last[:3])
        total, u_last = total + ticks * (J_1 + J_2 + J_3 + J_4) + J_5, u[k]
    return total


@pytest.mark.parametrize("span", [8, 31])
@pytest.mark.parametrize("error", ["predicted", "frozen"])
@pytest.mark.parametrize(
    ("kind", "tilt"),
    [
        ("flight", "flatness"),
        ("flight", "held"),
        ("exact", "flatness"),
        ("paper", "none"),
        ("velocity_aware", "held"),
    ],
)
def test_the_program_is_half_the_cost(kind, tilt, error, span, ticks_of, vehicle):
    """z' H z / 2 + g' z for any inputs, up to a constant."""
    config = dataclasses.replace(CONFIG, error=error, tilt=tilt, span_ticks=span)
    model = EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=K_B)), vehicle.joints)
    ours = MpcFormulation(config, model, vehicle)
    rng, N = np.random.default_rng(0), config.horizon
    # The target is so near that K_e is not limited.
    near = 0.05 * rng.normal(size=(N + 1, 6))
    tick = ticks_of(model)[70]
    near[:, :3] += tick.end_effector.p_E
    tick = dataclasses.replace(tick, reference=near, delta=rng.normal(size=3))
    program = ours.form(tick)
    still = cost(config, model, tick, vehicle.p_O, np.zeros((N, 3 + vehicle.joints)))
    for size in (0.1, 1.0, 10.0):
        z = size * rng.normal(size=len(ours.scale))
        u = ours.inputs(z)
        expected = cost(config, model, tick, vehicle.p_O, u) - still
        half = z @ program.H @ z / 2 + program.g @ z
        assert 2 * half == pytest.approx(expected, rel=1e-9, abs=1e-9 * still)

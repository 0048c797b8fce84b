"""Inverse kinematics against stacked least squares, and its closed-loop properties."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.clik import InverseKinematics
from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clik, Mpc

MPC = Mpc(k_e=(3.0, 2.0, 4.0), horizon=15, span_ticks=40)
SLOW = Clik(damping=0.3, centring_1_s=0.0, bandwidth_1_s=2.0)


def velocity_aware(vehicle: VehicleModel) -> EquivalentModel:
    return EquivalentModel.make("velocity_aware", np.ones(3), 0.02, vehicle.joints)


def inverse(vehicle: VehicleModel, config: Clik) -> InverseKinematics:
    return InverseKinematics(config, MPC, velocity_aware(vehicle), vehicle)


@pytest.fixture(params=[20, 60, 100])
def tick(ticks_of, vehicle, request) -> MpcInputs:
    """A tick in motion, away from the centre of the learning space."""
    return ticks_of(velocity_aware(vehicle))[request.param]


def desired_velocity(tick: MpcInputs) -> np.ndarray:
    """Returns v (3,) m/s."""
    e = tick.end_effector.p_E - tick.reference[0, :3]
    K_e = np.array(MPC.k_e)
    K_e = K_e * min(1, MPC.approach_speed_m_s / np.linalg.norm(K_e * e))
    return tick.reference[1, 3:] - K_e * e - tick.end_effector.J_c[:, 3] * tick.rpy_rates[2]


@pytest.mark.parametrize(("w_q", "w_m"), [(1100.0, 9.9), (100.0, 1000.0), (50.0, 50.0)])
def test_is_the_weighted_damped_least_squares_solution(tick, vehicle, w_q, w_m):
    """Minimiser of |J s - v|^2 + lambda^2 s' W s, with min W = 1, as one stacked problem."""
    tick = replace(tick, w_q=w_q, w_m=w_m)
    velocity = inverse(vehicle, SLOW).command(tick).velocity
    W = np.diag([w_q] * 3 + [w_m] * vehicle.joints) / min(w_q, w_m)
    stacked = np.vstack([tick.end_effector.J_s, SLOW.damping * np.sqrt(W)])
    right = np.concatenate([desired_velocity(tick), np.zeros(3 + vehicle.joints)])
    expected = np.linalg.lstsq(stacked, right)[0]
    np.testing.assert_allclose(velocity, expected, rtol=1e-9, atol=1e-12)


def test_small_damping_reaches_the_desired_velocity(tick, vehicle):
    velocity = inverse(vehicle, replace(SLOW, damping=1e-4)).command(tick).velocity
    np.testing.assert_allclose(tick.end_effector.J_s @ velocity, desired_velocity(tick), atol=1e-5)


def test_centring_is_a_null_space_motion(tick, vehicle):
    """p_EB - p_O decays at the centring rate."""
    config = replace(SLOW, damping=1e-4)
    without = inverse(vehicle, config).command(tick).velocity
    s_0 = inverse(vehicle, replace(config, centring_1_s=2.0)).command(tick).velocity - without
    offset = tick.end_effector.p_EB - vehicle.p_O
    assert np.linalg.norm(offset) > 1e-3
    np.testing.assert_allclose(tick.end_effector.J_s @ s_0, 0, atol=1e-9)
    np.testing.assert_allclose(tick.end_effector.J_B @ s_0[3:], -2.0 * offset, rtol=1e-3)


def test_weights_distribute_motion_between_base_and_arm(tick, vehicle):
    def speeds(w_q, w_m):
        config = replace(SLOW, damping=0.02)
        s = inverse(vehicle, config).command(replace(tick, w_q=w_q, w_m=w_m)).velocity
        J = tick.end_effector.J_s
        return np.linalg.norm(s[:3]), np.linalg.norm(J[:, 3:] @ s[3:])

    base, arm = speeds(100.0, 1000.0)
    assert base > 3 * arm
    less_base, more_arm = speeds(1100.0, 9.9)
    assert less_base < base / 1.5 and more_arm > 2 * arm


def test_inputs_follow_the_desired_velocity_within_bounds(tick, vehicle):
    calm = replace(tick, reference=np.tile(np.r_[tick.end_effector.p_E, np.zeros(3)], (16, 1)))
    ours = inverse(vehicle, SLOW)
    command = ours.command(calm)
    v_d, qdot_d = tick.x_0[3:12:4], tick.x_0[13::2]
    lag = command.velocity - np.concatenate([v_d, qdot_d])
    assert not command.is_clipped
    np.testing.assert_allclose(command.u, SLOW.bandwidth_1_s * lag, atol=1e-12)

    far = replace(tick, reference=tick.reference + 1.0)
    command = inverse(vehicle, replace(SLOW, bandwidth_1_s=50.0)).command(far)
    limits = np.concatenate([MPC.base_acceleration_m_s2, vehicle.acceleration])
    assert command.is_clipped
    assert np.all(np.abs(command.u) <= limits) and np.any(np.abs(command.u) == limits)


def test_prediction_extrapolates_at_constant_velocity(tick, vehicle):
    ours = inverse(vehicle, SLOW)
    velocity = ours.command(tick).velocity
    positions = ours.predict(tick, velocity)
    assert positions.shape == (MPC.horizon + 1, 3)
    np.testing.assert_array_equal(positions[0], tick.end_effector.p_E)
    durations = 0.02 * stage_ticks(MPC)
    assert durations.sum() == pytest.approx(0.8)
    expected = np.outer(durations, tick.end_effector.J_s @ velocity)
    np.testing.assert_allclose(np.diff(positions, axis=0), expected, atol=1e-12)

"""Joint PID: closed loop, limits, and recovery from saturation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.low_level.joint_pid import JointPid, control
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Arm

DT = 0.005


@pytest.fixture
def pid() -> JointPid:
    """A joint of 0.03 kg m^2 with its stops out of reach."""
    return make_pid([[0.03]], 40.0**2, 2 * 40.0, 5 * 40.0**2)


def make_pid(inertia, k_p, k_d, k_i, velocity=3.0, stop=9.0) -> JointPid:
    """Returns joints with a torque limit of 4 N m each."""
    same = np.ones(len(inertia))
    limits = 4 * same, velocity * same, -stop * same, stop * same
    return JointPid(np.array(inertia), 0 * same, k_p, k_d, k_i, *limits, DT)


def tick(pid: JointPid, error, rate_error, integral) -> tuple[np.ndarray, np.ndarray]:
    """Returns torque and next integral of joints with the given errors of angle and rate."""
    n = len(integral)
    state, setpoint = np.full(VehicleState.size(n), 9.0), np.full(3 * n, 9.0)
    state[7 : 7 + n] = state[-n:] = 0.0
    setpoint[:n], setpoint[n : 2 * n] = error, rate_error
    return control(pid, state, setpoint, integral)


def simulate(pid: JointPid, steps: int, *, disturbance=0.0, blocked=0, goal=0.5) -> np.ndarray:
    """Returns the path (steps,) rad of a joint of 0.03 kg m^2 to `goal`, blocked at first."""
    q, qdot, integral, path = 0.0, 0.0, np.zeros(1), []
    for k in range(steps):
        state = np.zeros(VehicleState.size(1))
        state[7], state[-1] = q, qdot
        (torque,), integral = control(pid, state, np.array([goal, 0.0, 0.0]), integral)
        assert abs(torque) <= pid.effort[0] and abs(integral[0]) <= pid.effort[0]
        if k >= blocked:
            acceleration = (torque + disturbance) / 0.03
            q, qdot = q + qdot * DT + acceleration * DT**2 / 2, qdot + acceleration * DT
        path.append(q)
    return np.array(path)


def test_gains_place_each_joints_poles(vehicle):
    arm = Arm(bandwidth_rad_s=30.0, damping=0.7, integral_rad_s=4.0)
    pid = JointPid.make(arm, vehicle, DT)
    poles = np.roots([1.0, pid.k_d, pid.k_p])
    np.testing.assert_allclose(np.abs(poles), 30.0)
    np.testing.assert_allclose(-poles.real / 30.0, 0.7)
    np.testing.assert_allclose(pid.k_i / pid.k_p, 4.0)
    np.testing.assert_array_equal(pid.inertia, vehicle.arm_inertia)
    diagonal = JointPid.make(replace(arm, inertia="diagonal"), vehicle, DT).inertia
    np.testing.assert_array_equal(diagonal, np.diag(np.diag(vehicle.arm_inertia)))
    for limit in ("effort", "velocity", "lower", "upper"):
        np.testing.assert_array_equal(getattr(pid, limit), getattr(vehicle, limit))
    assert pid.dt == DT


def test_torque_is_linear_within_its_limits_and_clipped_beyond():
    pid = make_pid(np.eye(4), 10.0, 2.0, 30.0, velocity=9.0)
    error, rate_error = np.array([0.1, -0.1, 1.0, -1.0]), np.array([0.2, 0.3, 0.0, 0.0])
    torque, _ = tick(pid, error, rate_error, np.array([0.5, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(torque, [1.9, -0.4, 4.0, -4.0])


def test_the_integral_is_that_of_the_error_within_limits(pid):
    errors = 0.02 * np.sin(np.arange(40))
    integral = np.zeros(1)
    for error in errors:
        _, integral = tick(pid, error, 0.0, integral)
    assert integral[0] == pytest.approx(0.03 * pid.k_i * errors.sum() * DT)


def test_a_constant_torque_is_compensated(pid):
    path = simulate(pid, 800, disturbance=-1.5, goal=0.02)
    assert abs(path[-1] - 0.02) < 1e-4
    without_integral = pid._replace(k_i=0.0)
    droop = 0.02 - simulate(without_integral, 800, disturbance=-1.5, goal=0.02)[-1]
    assert droop == pytest.approx(1.5 / (0.03 * pid.k_p), rel=1e-3)


def test_no_windup_while_the_joint_is_blocked(pid):
    """After any time of blocking it moves as if it had not been blocked."""
    free = simulate(pid, 600, goal=0.1)
    blocked = simulate(pid, 600 + 1000, blocked=1000, goal=0.1)
    np.testing.assert_allclose(blocked[1000:], free, atol=1e-12)
    assert free.max() < 0.1 * 1.25
    assert abs(free[-1] - 0.1) < 1e-3


def test_a_full_integral_unwinds_at_once(pid):
    """In saturation it still integrates an error of the opposite sign."""
    full = pid.effort.copy()
    _, back = tick(pid, -0.001, 0.1, full)
    assert back[0] == pytest.approx(full[0] - 0.03 * pid.k_i * 0.001 * DT)


def test_the_integral_never_exceeds_the_effort(pid):
    """Even if the rate term keeps the torque within its limit."""
    full = pid.effort.copy()
    for sign in (1, -1):
        torque, integral = tick(pid, 0.02 * sign, -1.0 * sign, full * sign)
        assert abs(torque[0]) < pid.effort[0]
        np.testing.assert_array_equal(integral, full * sign)


@pytest.mark.parametrize("load", [0.0, 2.0, -2.0])
@pytest.mark.parametrize("goal", [3.0, -3.0])
def test_far_setpoints_are_approached_at_the_velocity_limit(pid, goal, load):
    """After any time of blocking; an unknown load changes the rate by load / k_d."""
    path = simulate(pid, 1500, goal=goal, disturbance=load, blocked=500)
    rate, limit = np.abs(np.diff(path)) / DT, pid.velocity[0]
    assert rate.max() < 1.02 * limit + abs(load) / (0.03 * pid.k_d)
    assert np.median(rate[600:650]) == pytest.approx(limit, rel=0.03)
    assert path[-1] == pytest.approx(goal, abs=1e-3)


@pytest.mark.parametrize("goal", [1.1, 1.5, 40.0])
def test_no_setpoint_drives_a_joint_beyond_its_stop(goal):
    pid = make_pid([[0.03]], 40.0**2, 2 * 40.0, 5 * 40.0**2, stop=1.0)
    for load in (0.0, 1.0):
        path = simulate(pid, 1500, goal=goal, disturbance=load)
        assert path.max() < 1.0 + np.radians(0.5)
        assert path[-1] == pytest.approx(1.0, abs=1e-3)


@given(st.floats(-2, 2), st.floats(-5, 5), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_torque_is_that_of_a_cascade_with_a_limited_rate(error, rate_error, angle, integral):
    pid = make_pid([[0.03]], 40.0**2, 2 * 40.0, 5 * 40.0**2, stop=1.0)
    state, setpoint = np.zeros(VehicleState.size(1)), np.array([angle + error, rate_error, 0.0])
    state[7] = angle
    torque, new_integral = control(pid, state, setpoint, np.array([integral]))
    desired_rate = np.clip(rate_error + 20 * error, -3, 3)
    desired_rate = np.clip(desired_rate, 20 * (-1 - angle), 20 * (1 - angle))
    assert torque[0] == pytest.approx(np.clip(2.4 * desired_rate + integral, -4, 4), abs=1e-9)
    assert abs(new_integral[0]) <= 4

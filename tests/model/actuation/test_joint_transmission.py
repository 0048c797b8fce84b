"""Backlash and flexibility of one joint against closed forms and an ODE solver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from aerodrake.model.actuation.joint_transmission import JointTransmission, load, turn
from aerodrake.scenario import Actuation

DT, DAMPING = 0.001, 4 / 3
GAPS, FLEXIBILITIES = st.sampled_from([0.0, 0.002, 0.02]), st.sampled_from([0.0, 0.003, 0.05])
TORQUES = st.floats(-4, 4, allow_subnormal=False)


def joint(gap: float = 0.0, flexibility: float = 0.0, dt: float = DT) -> JointTransmission:
    return JointTransmission(*(np.array([x]) for x in (gap, flexibility, DAMPING, 0.0, 4.0)), dt)


def simulate(model: JointTransmission, torque: np.ndarray, s: float = 0.0) -> np.ndarray:
    """Returns twist and torque on the link (steps, 2) for motor torques (steps,)."""
    last, rows = np.array([s]), []
    for value in torque:
        after, contact = turn(model, last, np.array([value]))
        rows.append((last[0], contact[0] * value))
        last = after
    return np.array(rows)


@pytest.mark.parametrize("torque", [0.5, -2.0])
def test_deflection_is_compliance_times_torque(torque):
    """It is approached exponentially, with compliance times damping as time constant."""
    s, T = simulate(joint(flexibility=0.01), np.full(1000, torque)).T
    lag = 0.01 * DAMPING
    np.testing.assert_allclose(
        s, 0.01 * torque * -np.expm1(-DT / lag * np.arange(1000)), atol=1e-12
    )
    np.testing.assert_array_equal(T, torque)


def test_the_motor_crosses_the_gap_at_torque_over_damping_without_moving_the_link():
    gap, torque = 0.01, 0.5
    s, T = simulate(joint(gap), np.full(200, torque), s=-gap).T
    crossing_s = 2 * gap * DAMPING / torque
    time = DT * np.arange(200)
    np.testing.assert_allclose(s, np.minimum(-gap + torque / DAMPING * time, gap), atol=1e-12)
    np.testing.assert_allclose(T[time < crossing_s - DT], 0, atol=1e-9)
    np.testing.assert_allclose(T[time > crossing_s], torque)
    # The impulse that the link does not get.
    assert np.sum(torque - T) * DT == pytest.approx(2 * gap * DAMPING)


def test_the_hysteresis_loop_is_as_wide_as_the_backlash():
    """Motor and link turn forth and back under a friction torque that is larger than the load."""
    gap, phase = 0.005, np.linspace(0, 6 * np.pi, 6000)
    s, _ = simulate(joint(gap), np.cos(phase)).T
    link = 0.1 * np.sin(phase)
    motor, middle = link + s, np.abs(link) < 0.01
    forth, back = np.cos(phase) > 0.5, np.cos(phase) < -0.5
    started = phase > 2 * np.pi
    np.testing.assert_allclose((motor - link)[middle & forth & started], gap)
    np.testing.assert_allclose((motor - link)[middle & back & started], -gap)


def ode(model: JointTransmission, torque: float, s: float) -> float:
    """Returns the twist after a step by an ODE solver, for a flexible joint."""
    gap, flexibility = model.gap[0], model.flexibility[0]

    def rate(t, y):
        return (torque - (y - np.clip(y, -gap, gap)) / flexibility) / DAMPING

    return solve_ivp(rate, (0, model.dt), [s], rtol=1e-9, atol=1e-12, max_step=model.dt / 50).y[
        0, -1
    ]


@pytest.mark.parametrize("torque", [-3.0, -0.4, 0.0, 0.4, 3.0])
@pytest.mark.parametrize("start", [-0.02, -0.006, 0.001, 0.006, 0.02])
def test_a_long_step_equals_the_ode(torque, start):
    model = joint(0.005, 0.004, dt=0.02)
    after = turn(model, np.array([start]), np.array([torque])).twist[0]
    assert after == pytest.approx(ode(model, torque, start), abs=1e-7)


@given(GAPS, FLEXIBILITIES, TORQUES, st.floats(-1, 1), st.floats(0.01, 0.99))
def test_two_steps_equal_one(gap, flexibility, torque, place, share):
    start = place * (gap + 4 * flexibility)
    motor, steps = np.array([torque]), (0.02, 0.02 * share, 0.02 * (1 - share))
    long, short, rest = (joint(gap, flexibility, dt) for dt in steps)
    whole = turn(long, np.array([start]), motor)
    first = turn(short, np.array([start]), motor)
    second = turn(rest, first.twist, motor)
    np.testing.assert_allclose(second.twist, whole.twist, atol=1e-9)
    contact = share * first.contact + (1 - share) * second.contact
    np.testing.assert_allclose(contact, whole.contact, atol=1e-9)


@given(GAPS, FLEXIBILITIES, st.lists(TORQUES, max_size=30))
def test_the_motor_bounds_twist_and_torque(gap, flexibility, torques):
    """The twist is bounded by the largest torque, and so is the torque on the link."""
    s, T = simulate(joint(gap, flexibility), np.array([0.0, *torques])).T
    most = np.max(np.abs(torques), initial=0.0)
    assert np.abs(s).max() <= gap + flexibility * most + 1e-12
    assert np.abs(T).max() <= most + 1e-9


def test_it_starts_at_rest_in_trim(vehicle):
    config = Actuation(backlash_rad=(0.01,), flexibility_rad_n_m=(0.02,))
    model = JointTransmission.make(config, vehicle, DT)
    trim = vehicle.trim_torque
    rest = model.at_rest(trim)
    side = np.sign(trim) * (np.abs(trim) > 0.1)
    assert np.abs(side).sum() == 2  # The others carry no load.
    np.testing.assert_allclose(rest, 0.02 * trim + 0.005 * side, atol=1e-15)
    after, contact = turn(model, rest, trim)
    np.testing.assert_allclose(after, rest, atol=1e-15)
    np.testing.assert_allclose(contact * trim, trim, atol=1e-12)


def test_the_load_is_the_torque_less_that_of_the_motors_own_inertia(vehicle):
    """Rotors of 6e-7 and 2.7e-7 kg m^2 behind gears of 200 and 150."""
    model = JointTransmission.make(Actuation(backlash_rad=(0.01,)), vehicle, DT)
    inertia = np.repeat([6e-7 * 200**2, 2.7e-7 * 150**2], 3)
    np.testing.assert_allclose(model.motor_inertia, inertia)
    torque, acceleration = np.full(6, 0.5), 10.0
    loads = load(model, torque, np.full(6, acceleration * DT))
    np.testing.assert_allclose(loads, torque - inertia * acceleration)
    np.testing.assert_array_equal(load(model, torque, np.full(6, -1e3)), vehicle.effort)

"""Joint friction against closed forms of one joint, and on the coupled arm by its energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.actuation.joint_friction import (
    JointFriction,
    deflection,
    friction_torque,
    smallest_inertia,
)
from aerodrake.scenario import Actuation
from aerodrake.support.errors import ScenarioError

DT, INERTIA = 0.001, 0.02
STIFF = 0.1 * INERTIA / DT**2, 0.5 * INERTIA / DT


def friction(coulomb: float = 0.1, viscous: float = 0.0) -> JointFriction:
    """Returns the friction of one joint of `INERTIA`."""
    mean = -np.expm1(-viscous * DT / INERTIA) * INERTIA / DT
    return JointFriction(*(np.array([x]) for x in (coulomb, *STIFF, mean)), DT)


def simulate(model: JointFriction, v: float, torque, steps: int) -> np.ndarray:
    """Returns angle, velocity and friction torque (steps, 3) of a joint under motor torques."""
    q, last, rows = 0.0, np.zeros(1), []
    for k in range(steps):
        rate = np.array([v])
        f = friction_torque(model, last, rate)[0]
        last = deflection(model, last, rate)
        rows.append((q, v, f))
        v += DT / INERTIA * (torque(k * DT) + f)
        q += DT * v
    return np.array(rows)


def test_a_sliding_joint_decelerates_at_the_coulomb_torque_over_inertia_and_stops():
    v_0, c = 1.0, 0.1
    q, v, f = simulate(friction(c), v_0, lambda t: 0.0, 600).T
    time, stop_s = DT * np.arange(600), v_0 * INERTIA / c
    sliding = (time > 0.002) & (time < stop_s - 0.005)
    np.testing.assert_allclose(f[sliding], -c, rtol=1e-12)
    np.testing.assert_allclose(np.diff(v[sliding]) / DT, -c / INERTIA, rtol=1e-9)
    assert np.abs(v[time > stop_s + 0.05]).max() < 1e-6
    assert q[-1] == pytest.approx(v_0 * stop_s / 2, rel=0.01)


@pytest.mark.parametrize("share", [0.3, 0.99, -0.9])
def test_a_stuck_joint_holds_below_the_breakaway_torque_and_does_not_creep(share):
    """The torque rises within 0.1 s; the joint moves by the elastic deflection alone."""
    torque = share * 0.1
    q, v, f = simulate(friction(), 0.0, lambda t: torque * min(10 * t, 1.0), 10_000).T
    np.testing.assert_allclose(q[500:], torque / STIFF[0], rtol=1e-9)
    np.testing.assert_allclose(f[500:], -torque, rtol=1e-9)
    assert np.abs(v[500:]).max() < 1e-12


def test_a_vibration_below_the_breakaway_torque_does_not_creep():
    q = simulate(friction(), 0.0, lambda t: 0.05 + 0.045 * np.sin(60 * t), 10_000)[:, 0]
    assert q[5_000:].max() < 1.05 * 0.1 / STIFF[0]
    assert abs(q[8_000:].mean() - q[6_000:8_000].mean()) < 1e-2 * 0.1 / STIFF[0]


def test_above_the_breakaway_torque_the_rest_accelerates():
    v = simulate(friction(), 0.0, lambda t: 0.13, 500)[:, 1]
    np.testing.assert_allclose(np.diff(v[20:]) / DT, 0.03 / INERTIA, rtol=1e-9)


@pytest.mark.parametrize("viscous", [0.01, 1.0, 100.0])
def test_viscous_friction_decays_exponentially_at_any_coefficient(viscous):
    v = simulate(friction(0.0, viscous), 1.0, lambda t: 0.0, 50)[:, 1]
    np.testing.assert_allclose(v, np.exp(-viscous / INERTIA * DT * np.arange(50)), atol=1e-12)


@given(st.floats(-3, 3), st.floats(0.28, 20), st.floats(0, 1))
def test_energy_of_joint_and_spring_does_not_grow(v, ratio, c):
    """For joints of 0.28 to 20 times the assumed inertia, up to that of one explicit step."""
    model, last, energy = friction(c), np.zeros(1), []
    for _ in range(300):
        f = friction_torque(model, last, np.array([v]))[0]
        last = deflection(model, last, np.array([v]))
        energy.append(ratio * INERTIA * v**2 / 2 + STIFF[0] * last[0] ** 2 / 2)
        v += DT / (ratio * INERTIA) * f
    spring = (c / STIFF[0]) ** 2 * STIFF[0] / 2
    assert np.diff(energy).max() < 4 * spring + 1e-15
    assert energy[-1] <= energy[0] + 1e-15


def test_smallest_inertia_is_a_bound(vehicle):
    M = vehicle.arm_inertia
    D = smallest_inertia(M)
    assert np.linalg.eigvalsh(M - np.diag(D)).min() > -1e-12
    np.testing.assert_allclose(smallest_inertia(np.diag([2.0, 3.0])), [2, 3])


def test_values_are_one_or_one_for_each_joint(vehicle):
    each = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    config = Actuation(coulomb_n_m=each, viscous_n_m_s_rad=(0.1,))
    model = JointFriction.make(config, vehicle, DT)
    np.testing.assert_array_equal(model.coulomb, each)
    np.testing.assert_allclose(model.viscous, 0.1, rtol=0.02)
    with pytest.raises(ScenarioError, match="actuation.coulomb_n_m: expected 1 value, or 6"):
        JointFriction.make(Actuation(coulomb_n_m=(0.1, 0.2)), vehicle, DT)

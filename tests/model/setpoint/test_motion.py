"""Motions with piecewise constant accelerations, as those of the MPC."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.setpoint.integration import integrate
from aerodrake.model.setpoint.motion import held_acceleration_motion

VELOCITIES = arrays(
    float, st.tuples(st.integers(2, 12), st.integers(1, 4)), elements=st.floats(-3, 3)
)


@given(velocity=VELOCITIES, period=st.sampled_from([0.005, 0.02, 0.1]))
def test_it_is_the_double_integral_of_the_acceleration(velocity, period):
    """At the ticks and in between."""
    p = np.linspace(-1, 1, velocity.shape[1])
    motion = held_acceleration_motion(p, velocity, period)
    speed, rate = motion.MakeDerivative(1), motion.MakeDerivative(2)
    assert motion.start_time() == 0
    assert motion.end_time() == pytest.approx(period * (len(velocity) - 1))
    for tick, (v, after) in enumerate(zip(velocity[:-1], velocity[1:], strict=True)):
        a = (after - v) / period
        for part in (0.0, 0.3, 0.9):
            expected = integrate(p, v, a, part * period)
            t = (tick + part) * period + 1e-9
            np.testing.assert_allclose(motion.value(t)[:, 0], expected[0], atol=1e-7)
            np.testing.assert_allclose(speed.value(t)[:, 0], expected[1], atol=1e-5)
            np.testing.assert_allclose(rate.value(t)[:, 0], a, atol=1e-6 * (1 + abs(a).max()))
        p, _ = integrate(p, v, a, period)


def test_a_circle_is_flown_around():
    """The integral of a circle's velocities, linear in between, closes."""
    t = np.linspace(0, 2 * np.pi, 1001)
    velocity = np.stack([-np.sin(t), np.cos(t)], axis=1)
    motion = held_acceleration_motion(np.array([1.0, 0.0]), velocity, t[1])
    places = motion.vector_values(t)
    np.testing.assert_allclose(np.linalg.norm(places, axis=0), 1, atol=1e-5)
    np.testing.assert_allclose(places[:, -1], [1, 0], atol=1e-12)


def test_rest_is_rest():
    motion = held_acceleration_motion(np.array([0.1, -2.0]), np.zeros((50, 2)), 0.02)
    np.testing.assert_array_equal(
        motion.vector_values(np.linspace(0, 0.98, 77)).T[:], [[0.1, -2.0]] * 77
    )

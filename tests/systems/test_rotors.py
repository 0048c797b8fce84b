"""Rotors: first-order lag against its closed form, limits, and trim."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.scenario import Mismatch, Rotor
from aerodrake.systems.rotors import make_rotors

CONFIG = Rotor(min_thrust_n=1.0, max_thrust_n=18.0, lag_up_s=0.0125, lag_down_s=0.025)
TRIM = np.array([9.0, 10.0, 8.0, 9.5])
PERIOD = 0.001


def fly(command, duration: float, period: float = PERIOD, **mismatch: float) -> np.ndarray:
    """Returns the thrusts (k,) N after `duration` s of a constant command, from trim."""
    rotors = make_rotors(CONFIG, Mismatch(**mismatch), TRIM, period)
    simulator = Simulator(rotors)
    context = simulator.get_mutable_context()
    rotors.get_input_port().FixValue(context, command)
    simulator.AdvanceTo(duration)
    return rotors.get_output_port().Eval(context)


def test_the_default_context_is_trim_and_an_equilibrium():
    rotors = make_rotors(CONFIG, Mismatch(), TRIM, PERIOD)
    np.testing.assert_array_equal(
        rotors.get_output_port().Eval(rotors.CreateDefaultContext()), TRIM
    )
    np.testing.assert_array_equal(fly(TRIM, 0.5), TRIM)


@pytest.mark.parametrize("period", [0.001, 0.004])
@pytest.mark.parametrize("duration", [0.004, 0.020, 0.100])
def test_lag_is_exact_up_and_down(duration, period):
    command = np.array([12.0, 6.0, 8.5, 2.0])
    tau = np.array([0.0125, 0.025, 0.0125, 0.025])
    expected = command + (TRIM - command) * np.exp(-duration / tau)
    np.testing.assert_allclose(fly(command, duration, period), expected, rtol=1e-12)


def test_commands_beyond_the_limits_lag_towards_the_limits():
    command = np.array([100.0, -100.0, 18.5, 0.5])
    limit = np.array([18.0, 1.0, 18.0, 1.0])
    tau = np.array([0.0125, 0.025, 0.0125, 0.025])
    expected = limit + (TRIM - limit) * np.exp(-0.02 / tau)
    np.testing.assert_allclose(fly(command, 0.02), expected, rtol=1e-12)
    np.testing.assert_allclose(fly(command, 1.0), limit, rtol=1e-9)


@pytest.mark.parametrize("scale", [0.2, 1.2, 5.0])
def test_a_mismatch_scales_the_time_constants(scale):
    command = np.array([12.0, 6.0, 8.5, 2.0])
    tau = scale * np.array([0.0125, 0.025, 0.0125, 0.025])
    expected = command + (TRIM - command) * np.exp(-0.02 / tau)
    np.testing.assert_allclose(fly(command, 0.02, rotor_lag_scale=scale), expected, rtol=1e-12)


@pytest.mark.parametrize("scale", [0.1, 0.8, 1.5])
def test_thrust_deviates_from_trim_by_a_factor(scale):
    """A command of trim gives trim."""
    deviation = np.array([3.0, -4.0, 0.0, -1.0])
    tau = np.array([0.0125, 0.025, 0.0125, 0.025])
    expected = TRIM + scale * deviation * (1 - np.exp(-0.02 / tau))
    flown = fly(TRIM + deviation, 0.02, thrust_scale=scale)
    np.testing.assert_allclose(flown, expected, rtol=1e-12)


def test_the_limits_apply_after_the_factor():
    flown = fly(TRIM + [5.0, -5.0, 1.0, -1.0], 1.0, thrust_scale=5.0)
    np.testing.assert_allclose(flown, [18.0, 1.0, 13.0, 4.5], rtol=1e-9)


def test_rate_and_feedthrough():
    rotors = make_rotors(CONFIG, Mismatch(), TRIM, PERIOD)
    timing = rotors.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, 0)
    assert not rotors.HasAnyDirectFeedthrough()
    assert rotors.get_input_port().size() == rotors.get_output_port().size() == len(TRIM)

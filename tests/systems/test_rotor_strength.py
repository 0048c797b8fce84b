"""Scatter of the rotors' thrusts, and sag of the battery."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.scenario import Actuation, Scenario
from aerodrake.systems.rotor_strength import make_rotor_strength, thrust_factors

THRUST = np.array([9.0, 10.0, 8.0, 9.5])


def scenario(**flaws: float) -> Scenario:
    return Scenario(settle_s=2.0, duration=8.0, seed=3, actuation=Actuation(**flaws))


def at(system, time: float) -> np.ndarray:
    context = system.CreateDefaultContext()
    context.SetTime(time)
    system.get_input_port().FixValue(context, THRUST)
    return system.get_output_port().Eval(context)


def test_there_is_no_system_without_flaws():
    assert make_rotor_strength(scenario(), 4) is None


@pytest.mark.parametrize(("time", "lost"), [(0, 0), (2.5, 0.025), (10, 0.1), (12, 0.1)])
def test_the_sag_is_linear_over_the_flight(time, lost):
    system = make_rotor_strength(scenario(sag=0.1), 4)
    np.testing.assert_allclose(at(system, time), (1 - lost) * THRUST, rtol=1e-14)


def test_scatter_is_drawn_from_the_seed_with_its_deviation():
    flown = scenario(thrust_scatter=0.05)
    factors = at(make_rotor_strength(flown, 4), 1.0) / THRUST
    np.testing.assert_allclose(factors, thrust_factors(flown, 4))
    np.testing.assert_array_equal(thrust_factors(flown, 4), thrust_factors(flown, 4))
    assert np.all(thrust_factors(replace(flown, seed=4), 4) != factors)
    many = np.concatenate([thrust_factors(replace(flown, seed=s), 6) for s in range(500)])
    assert many.mean() == pytest.approx(1, abs=0.004)
    assert many.std() == pytest.approx(0.05, rel=0.05)


def test_scatter_is_proportional_to_its_deviation():
    small, large = (thrust_factors(scenario(thrust_scatter=s), 4) - 1 for s in (0.01, 0.1))
    np.testing.assert_allclose(large, 10 * small, rtol=1e-9)

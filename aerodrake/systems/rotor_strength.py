"""Differences of the rotors' thrusts from those of their model, and sag of the battery."""

import numpy as np
from pydrake.symbolic import Variable, max, min
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.scenario import Scenario
from aerodrake.support.arguments import Count, checked


def thrust_factors(scenario: Scenario, rotors: int) -> np.ndarray:
    """Returns the factors (k,) on the thrusts of k = `rotors` rotors, drawn from the seed.

    They are normally distributed about 1 with the deviation `actuation.thrust_scatter`. The vehicle
    has the same factors in all flights of one seed, whatever else is random.
    """
    draws = np.random.default_rng(scenario.seed).standard_normal(rotors)
    return np.maximum(1 + scenario.actuation.thrust_scatter * draws, 0.0)


@checked
def make_rotor_strength(scenario: Scenario, rotors: Count) -> SymbolicVectorSystem | None:
    """Makes the system that scales thrusts, with k = `rotors`; None without scatter and sag.

    The factor of the sag falls linearly with time, from 1 at the start to 1 - `actuation.sag` at
    the end of the scenario's duration, and is constant then.

    Ports:
        in `u0` (k): N, thrusts after lag and limits.
        out `y0` (k): N, thrusts times each rotor's factor and that of the sag.
    """
    config = scenario.actuation
    if config.thrust_scatter == 0 and config.sag == 0:
        return None
    time, thrust = Variable("t"), [Variable(f"f{i}") for i in range(rotors)]
    end_s = scenario.settle_s + scenario.duration
    left = 1 - config.sag * min(max(time / end_s, 0.0), 1.0)
    output = [
        factor * left * f
        for factor, f in zip(thrust_factors(scenario, rotors), thrust, strict=True)
    ]
    return SymbolicVectorSystem(time, input=np.array(thrust), output=np.array(output))

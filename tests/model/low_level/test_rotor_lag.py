"""Rotor lag against its differential equation."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from aerodrake.model.low_level.rotor_lag import RotorLag, advance

UP, DOWN = 0.0125, 0.025


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize(("start", "command"), [(2.0, 9.0), (9.0, 2.0), (5.0, 5.0), (0.0, 20.0)])
def test_end_and_mean_solve_the_equation(start, command, dt):
    def slope(t, f):
        return (command - f) / (UP if command > f[0] else DOWN)

    solution = solve_ivp(slope, (0, dt), [start], rtol=1e-10, atol=1e-10, dense_output=True)
    mean = quad(lambda t: solution.sol(t)[0], 0, dt, epsabs=1e-10)[0] / dt
    end, average = advance(RotorLag(UP, DOWN, dt), np.array([start]), np.array([command]))
    np.testing.assert_allclose(end, solution.y[:, -1], atol=1e-7)
    np.testing.assert_allclose(average, mean, atol=1e-7)


def test_rotors_lag_independently():
    lag = RotorLag(UP, DOWN, 0.01)
    starts, commands = np.array([2.0, 9.0, 4.0]), np.array([9.0, 2.0, 4.0])
    jointly = np.array(advance(lag, starts, commands))
    separately = [
        advance(lag, s, c) for s, c in zip(starts[:, None], commands[:, None], strict=True)
    ]
    np.testing.assert_array_equal(jointly, np.hstack(separately))

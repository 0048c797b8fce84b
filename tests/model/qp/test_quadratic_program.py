"""Bounds of a quadratic program, and constraints without the redundant ones."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.model.qp.quadratic_program import Constraints
from tests.qp_programs import NZ, ROWS, random_program


def test_cholesky_factor_and_minimiser():
    program = random_program(0)
    L = np.tril(program.factor)
    np.testing.assert_allclose(L @ L.T, program.H, atol=1e-12)
    np.testing.assert_allclose(program.H @ program.minimiser, -program.g, atol=1e-10)
    indefinite = replace(program, H=program.H - 1e3 * np.eye(NZ))
    assert indefinite.factor is None and np.isnan(indefinite.minimiser).all()


def test_only_rows_that_some_z_violates_remain():
    program = random_program(1)
    reach = np.abs(program.A).sum(axis=1)
    lower, upper = np.full(ROWS, -np.inf), reach + 1e-9
    upper[3], lower[5] = reach[3] - 1e-9, -reach[5] + 1e-9
    constraints = Constraints.of(replace(program, lower=lower, upper=upper))
    np.testing.assert_array_equal(constraints.N, [*np.eye(NZ), program.A[3], program.A[5]])
    np.testing.assert_array_equal(constraints.lower[NZ:], lower[[3, 5]])
    np.testing.assert_array_equal(constraints.upper[NZ:], upper[[3, 5]])


def test_violations_are_positive_outside():
    constraints = Constraints.of(random_program(2))
    z = np.zeros(NZ)
    z[0], z[1] = 1.5, -1.25
    violations = constraints.violations(z)
    assert violations[0] == 0.5 and violations[1] == 0.25 and violations[2] == -1.0
    row = constraints.N[NZ] @ z
    expected = max(row - constraints.upper[NZ], constraints.lower[NZ] - row)
    assert violations[NZ] == pytest.approx(expected)


def test_is_feasible_within_all_bounds():
    program, z = random_program(3), np.full(NZ, 0.25)
    below, above = program.A @ z - 0.1, program.A @ z + 0.1

    def is_feasible(z, lower, upper) -> bool:
        return replace(program, lower=lower, upper=upper).is_feasible(z)

    assert is_feasible(z, below, above)
    assert not is_feasible(z * np.nan, below, above)
    for i in (0, ROWS - 1):
        cut = above.copy()
        cut[i] -= 0.2
        assert not is_feasible(z, below, cut)
        cut = below.copy()
        cut[i] += 0.2
        assert not is_feasible(z, cut, above)
    z[-1] = 1.1
    assert not is_feasible(z, np.full(ROWS, -np.inf), np.full(ROWS, np.inf))

"""Exchanging active bounds, against a solver that knows nothing of them."""

import clarabel
import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve

from aerodrake.model.active_set import exchange_active_set

NZ, ROWS = 8, 14


def program(seed: int):
    """A feasible program whose minimiser is held by bounds."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(NZ, NZ))
    H, g = root @ root.T + np.eye(NZ), 10 * rng.normal(size=NZ)
    A, middle = rng.normal(size=(ROWS, NZ)), rng.normal(size=NZ)
    slack = rng.uniform(0.05, 1.0, (2, ROWS))
    return H, g, A, A @ middle - slack[0], A @ middle + slack[1]


def exchange(H, g, A, lower, upper, prices):
    factor = cho_factor(H)
    return exchange_active_set(factor, -cho_solve(factor, g), A, lower, upper, prices)


def by_clarabel(H, g, A, lower, upper):
    """(minimiser, prices of the rows)"""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    G, h = sparse.csc_matrix(np.vstack([A, -A])), np.concatenate([upper, -lower])
    H = sparse.triu(sparse.csc_matrix(H), format="csc")
    cone = [clarabel.NonnegativeConeT(len(h))]
    solution = clarabel.DefaultSolver(H, g, G, h, cone, settings).solve()
    dual = np.array(solution.z).reshape(2, -1)
    return np.array(solution.x), dual[1] - dual[0]


@pytest.mark.parametrize("seed", range(50))
def test_a_good_guess_becomes_exact(seed):
    H, g, A, lower, upper = program(seed)
    best, prices = by_clarabel(H, g, A, lower, upper)
    blurred = prices * np.random.default_rng(seed).uniform(0.5, 2.0, ROWS)
    np.testing.assert_allclose(exchange(H, g, A, lower, upper, blurred), best, atol=1e-7)


def test_a_poor_guess_becomes_exact_or_nothing():
    found = 0
    for seed in range(50):
        H, g, A, lower, upper = program(seed)
        best, prices = by_clarabel(H, g, A, lower, upper)
        clear = np.abs(prices) > 1e-6
        weakest = np.abs(prices) == np.abs(prices[clear]).min()
        z = exchange(H, g, A, lower, upper, np.where(weakest, 0.0, prices))
        if z is not None:
            np.testing.assert_allclose(z, best, atol=1e-7)
            found += 1
    assert found > 25


def test_rows_that_others_imply_are_let_go():
    H, g, A, lower, upper = program(3)
    best, prices = by_clarabel(H, g, A, lower, upper)
    twice = [np.concatenate([part, part]) for part in (lower, upper, prices)]
    z = exchange(H, g, np.vstack([A, A]), *twice)
    np.testing.assert_allclose(z, best, atol=1e-7)


def test_a_minimiser_that_no_bound_holds():
    H, g, A, *_ = program(4)
    free = -np.linalg.solve(H, g)
    wide = np.full(ROWS, 1e3)
    np.testing.assert_allclose(exchange(H, g, A, -wide, wide, np.ones(ROWS)), free, atol=1e-9)


def test_contradicting_bounds_have_no_minimiser():
    H, g, A, lower, upper = program(5)
    A[1], lower[0], upper[0], lower[1], upper[1] = A[0], 3.0, 4.0, -4.0, -3.0
    assert exchange(H, g, A, lower, upper, np.ones(ROWS)) is None

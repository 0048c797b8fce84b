"""Exchanging active bounds, against a solver that knows nothing of them."""

import clarabel
import numpy as np
import pytest
from scipy import sparse

from aerodrake.model.qp.active_set import exchange_active_set
from aerodrake.model.qp.banded_rows import BandedRows

NZ, ROWS = 8, 14
SEEDS = range(50)


def program(seed: int):
    """A feasible program whose minimiser is held by bounds."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(NZ, NZ))
    H, g = root @ root.T + np.eye(NZ), 10 * rng.normal(size=NZ)
    A, inside = rng.normal(size=(ROWS, NZ)), rng.uniform(-0.5, 0.5, NZ)
    slack = rng.uniform(0.05, 1.0, (2, ROWS))
    return H, g, A, A @ inside - slack[0], A @ inside + slack[1]


def exchange(H, g, A, lower, upper, guess, most=100):
    V = np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(H)).T)
    return exchange_active_set(
        V, -np.linalg.solve(H, g), BandedRows.of(A), lower, upper, guess, most
    )


def by_clarabel(H, g, A, lower, upper) -> tuple[np.ndarray, np.ndarray]:
    """(minimiser, active bounds)"""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    rows, box = np.vstack([np.eye(NZ), A]), np.ones(NZ)
    upper, lower = np.concatenate([box, upper]), np.concatenate([-box, lower])
    G, h = sparse.csc_matrix(np.vstack([rows, -rows])), np.concatenate([upper, -lower])
    H = sparse.triu(sparse.csc_matrix(H), format="csc")
    cone = [clarabel.NonnegativeConeT(len(h))]
    solution = clarabel.DefaultSolver(H, g, G, h, cone, settings).solve()
    price = np.array(solution.z).reshape(2, -1) > 1e-6
    return np.array(solution.x), price[0].astype(np.int64) - price[1]


@pytest.mark.parametrize("seed", SEEDS)
def test_from_any_guess_to_the_solution(seed):
    """None, the active bounds themselves, some of them, and any."""
    given = program(seed)
    best, active = by_clarabel(*given)
    rng = np.random.default_rng(seed)
    blurred = np.where(rng.random(NZ + ROWS) < 0.3, rng.integers(-1, 2, NZ + ROWS), active)
    for guess in (0 * active, active, blurred, rng.integers(-1, 2, NZ + ROWS)):
        is_exact, z, found = exchange(*given, guess)
        assert is_exact
        np.testing.assert_allclose(z, best, atol=1e-7)
        np.testing.assert_array_equal(found, active)


def test_the_right_guess_needs_no_exchange():
    for seed in SEEDS:
        given = program(seed)
        best, active = by_clarabel(*given)
        assert not exchange(*given, 0 * active, most=1)[0]
        is_exact, z, _ = exchange(*given, active, most=1)
        assert is_exact
        np.testing.assert_allclose(z, best, atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_rows_that_others_imply(seed):
    """Each row twice, and their sums: more rows at their bounds than z has elements."""
    H, g, A, lower, upper = program(seed)
    best, _ = by_clarabel(H, g, A, lower, upper)
    sums = A[:-1] + A[1:]
    rows = np.vstack([A, A, sums])
    low = np.concatenate([lower, lower, lower[:-1] + lower[1:]])
    high = np.concatenate([upper, upper, upper[:-1] + upper[1:]])
    rng = np.random.default_rng(seed)
    for guess in (np.zeros(NZ + len(rows)), rng.integers(-1, 2, NZ + len(rows))):
        is_exact, z, _ = exchange(H, g, rows, low, high, guess.astype(np.int64))
        assert is_exact
        np.testing.assert_allclose(z, best, atol=1e-7)


def test_a_vertex():
    """As many active bounds as unknowns."""
    best = np.sign(np.random.default_rng(0).normal(size=NZ))
    H, A = np.eye(NZ), np.zeros((0, NZ))
    is_exact, z, found = exchange(
        H, -5 * best, A, np.zeros(0), np.zeros(0), np.zeros(NZ, dtype=np.int64)
    )
    assert is_exact
    np.testing.assert_allclose(z, best, atol=1e-12)
    np.testing.assert_array_equal(found, best)


def test_a_minimiser_that_no_bound_holds():
    H, g, A, *_ = program(4)
    g = 1e-3 * g
    wide = np.full(ROWS, 1e3)
    guess = np.ones(NZ + ROWS, dtype=np.int64)
    is_exact, z, found = exchange(H, g, A, -wide, wide, guess)
    assert is_exact and not found.any()
    np.testing.assert_allclose(z, -np.linalg.solve(H, g), atol=1e-9)


@pytest.mark.parametrize("guess", [0, 1, -1])
def test_contradicting_bounds_have_no_minimiser(guess):
    H, g, A, lower, upper = program(5)
    A[1], lower[0], upper[0], lower[1], upper[1] = A[0], 0.3, 0.4, -0.4, -0.3
    assert not exchange(H, g, A, lower, upper, np.full(NZ + ROWS, guess))[0]


def test_bounds_that_are_none_are_not_held():
    H, g, A, lower, upper = program(6)
    best, _ = by_clarabel(H, g, A, lower, upper + 20)  # Out of reach.
    guess = np.ones(NZ + ROWS, dtype=np.int64)
    is_exact, z, _ = exchange(H, g, A, lower, np.full(ROWS, np.inf), guess)
    assert is_exact
    np.testing.assert_allclose(z, best, atol=1e-7)

"""Dual active-set method against Clarabel, an interior-point solver."""

import clarabel
import numpy as np
import pytest
from scipy import sparse

from aerodrake.model.qp.active_set import ActiveSetSolution, FactorisedQp, solve_active_set
from aerodrake.model.qp.banded_rows import BandedRows

NZ, ROWS = 8, 14
SEEDS = range(50)


def program(seed: int):
    """Returns a feasible program whose minimiser has active constraints."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(NZ, NZ))
    H, g = root @ root.T + np.eye(NZ), 10 * rng.normal(size=NZ)
    A, inside = rng.normal(size=(ROWS, NZ)), rng.uniform(-0.5, 0.5, NZ)
    slack = rng.uniform(0.05, 1.0, (2, ROWS))
    return H, g, A, A @ inside - slack[0], A @ inside + slack[1]


def solve(H, g, A, lower, upper, guess, max_exchanges=100) -> ActiveSetSolution:
    V = np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(H)).T)
    qp = FactorisedQp(V, -np.linalg.solve(H, g), BandedRows.of(A), lower, upper)
    return solve_active_set(qp, guess, max_exchanges)


def by_clarabel(H, g, A, lower, upper) -> tuple[np.ndarray, np.ndarray]:
    """Returns the minimiser and its active set."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    rows, box = np.vstack([np.eye(NZ), A]), np.ones(NZ)
    upper, lower = np.concatenate([box, upper]), np.concatenate([-box, lower])
    G, h = sparse.csc_matrix(np.vstack([rows, -rows])), np.concatenate([upper, -lower])
    H = sparse.triu(sparse.csc_matrix(H), format="csc")
    cone = [clarabel.NonnegativeConeT(len(h))]
    solution = clarabel.DefaultSolver(H, g, G, h, cone, settings).solve()
    is_active = np.array(solution.z).reshape(2, -1) > 1e-6
    return np.array(solution.x), is_active[0].astype(np.int64) - is_active[1]


@pytest.mark.parametrize("seed", SEEDS)
def test_converges_from_any_guess(seed):
    """Guesses are empty, the active set itself, close to it, and random."""
    given = program(seed)
    best, active = by_clarabel(*given)
    rng = np.random.default_rng(seed)
    blurred = np.where(rng.random(NZ + ROWS) < 0.3, rng.integers(-1, 2, NZ + ROWS), active)
    for guess in (0 * active, active, blurred, rng.integers(-1, 2, NZ + ROWS)):
        solution = solve(*given, guess)
        assert solution.is_optimal
        np.testing.assert_allclose(solution.z, best, atol=1e-7)
        np.testing.assert_array_equal(solution.active, active)


def test_correct_guess_needs_no_exchange():
    for seed in SEEDS:
        given = program(seed)
        best, active = by_clarabel(*given)
        assert not solve(*given, 0 * active, max_exchanges=1).is_optimal
        solution = solve(*given, active, max_exchanges=1)
        assert solution.is_optimal
        np.testing.assert_allclose(solution.z, best, atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_linearly_dependent_constraints(seed):
    """Each row twice, and sums of rows: more active constraints than unknowns."""
    H, g, A, lower, upper = program(seed)
    best, _ = by_clarabel(H, g, A, lower, upper)
    sums = A[:-1] + A[1:]
    rows = np.vstack([A, A, sums])
    low = np.concatenate([lower, lower, lower[:-1] + lower[1:]])
    high = np.concatenate([upper, upper, upper[:-1] + upper[1:]])
    rng = np.random.default_rng(seed)
    for guess in (np.zeros(NZ + len(rows)), rng.integers(-1, 2, NZ + len(rows))):
        solution = solve(H, g, rows, low, high, guess.astype(np.int64))
        assert solution.is_optimal
        np.testing.assert_allclose(solution.z, best, atol=1e-7)


def test_vertex():
    """As many active constraints as unknowns."""
    best = np.sign(np.random.default_rng(0).normal(size=NZ))
    H, A = np.eye(NZ), np.zeros((0, NZ))
    solution = solve(H, -5 * best, A, np.zeros(0), np.zeros(0), np.zeros(NZ, dtype=np.int64))
    assert solution.is_optimal
    np.testing.assert_allclose(solution.z, best, atol=1e-12)
    np.testing.assert_array_equal(solution.active, best)


def test_unconstrained_minimiser():
    H, g, A, *_ = program(4)
    g = 1e-3 * g
    wide = np.full(ROWS, 1e3)
    guess = np.ones(NZ + ROWS, dtype=np.int64)
    solution = solve(H, g, A, -wide, wide, guess)
    assert solution.is_optimal and not solution.active.any()
    np.testing.assert_allclose(solution.z, -np.linalg.solve(H, g), atol=1e-9)


@pytest.mark.parametrize("guess", [0, 1, -1])
def test_infeasible_bounds_have_no_minimiser(guess):
    H, g, A, lower, upper = program(5)
    A[1], lower[0], upper[0], lower[1], upper[1] = A[0], 0.3, 0.4, -0.4, -0.3
    assert not solve(H, g, A, lower, upper, np.full(NZ + ROWS, guess)).is_optimal


def test_infinite_bounds_are_never_active():
    H, g, A, lower, upper = program(6)
    best, _ = by_clarabel(H, g, A, lower, upper + 20)  # Out of reach.
    guess = np.ones(NZ + ROWS, dtype=np.int64)
    solution = solve(H, g, A, lower, np.full(ROWS, np.inf), guess)
    assert solution.is_optimal
    np.testing.assert_allclose(solution.z, best, atol=1e-7)

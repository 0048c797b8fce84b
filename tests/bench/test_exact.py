"""The exact minimiser against closed forms and Clarabel."""

import clarabel
import numpy as np
import pytest
from scipy import sparse

from aerodrake.bench.exact import exact_minimiser

NZ, ROWS = 12, 20


def random_program(seed: int, pull: float):
    """(H, g, lower, upper, A), feasible; `pull` is the size of the unconstrained minimiser."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(ROWS, NZ))
    A /= np.linalg.norm(A, axis=1)[:, None]
    F = rng.normal(size=(NZ, NZ))
    H = 40 * (F.T @ F + 0.1 * np.eye(NZ))
    g = -H @ rng.uniform(-pull, pull, NZ)
    inside = A @ rng.uniform(-0.5, 0.5, NZ)
    lower, upper = inside - rng.uniform(0.01, 1, ROWS), inside + rng.uniform(0.01, 1, ROWS)
    return H, g, lower, upper, A


def by_clarabel(H, g, lower, upper, A) -> np.ndarray:
    identity = np.eye(len(g))
    rows = np.vstack([A, -A, identity, -identity])
    bound = np.concatenate([upper, -lower, np.ones(2 * len(g))])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(H)),
        g,
        sparse.csc_matrix(rows),
        bound,
        [clarabel.NonnegativeConeT(len(bound))],
        settings,
    ).solve()
    return np.array(solution.x)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("pull", [0.01, 2.0, 10.0])
def test_is_the_optimum(seed, pull):
    program = random_program(seed, pull)
    optimum = exact_minimiser(*program)
    np.testing.assert_allclose(optimum.z, by_clarabel(*program), atol=1e-7)
    assert optimum.residual < 1e-12
    H, g, lower, upper, A = program
    unconstrained = np.linalg.solve(H, -g)
    rows = A @ unconstrained
    is_inside = np.abs(unconstrained).max() <= 1 and np.all((rows >= lower) & (rows <= upper))
    assert optimum.is_constrained == (not is_inside)


def test_closed_form_in_a_corner():
    """The point closest to (3, 2) in the box and below x + y = 1.5, scaled to unit norm."""
    H, g = 2 * np.eye(2), -2 * np.array([3.0, 2.0])
    A = np.array([[1.0, 1.0]]) / np.sqrt(2)
    optimum = exact_minimiser(H, g, np.array([-np.inf]), np.array([1.5 / np.sqrt(2)]), A)
    np.testing.assert_allclose(optimum.z, [1.0, 0.5], atol=1e-12)
    assert optimum.is_constrained and optimum.residual < 1e-12


def test_linearly_dependent_constraints():
    H, g, lower, upper, A = random_program(3, 10.0)
    twice = exact_minimiser(H, g, np.tile(lower, 2), np.tile(upper, 2), np.vstack([A, A]))
    np.testing.assert_allclose(twice.z, exact_minimiser(H, g, lower, upper, A).z, atol=1e-9)
    assert twice.residual < 1e-9


def test_infeasible_programs_raise():
    H, g, lower, upper, A = random_program(0, 2.0)
    A[1] = A[0]
    lower[0], upper[0], lower[1], upper[1] = 0.3, 0.4, -0.4, -0.3
    with pytest.raises(ValueError, match="no z"):
        exact_minimiser(H, g, lower, upper, A)

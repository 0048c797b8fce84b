"""CondensedQp: solutions, redundant constraints and statuses, against Clarabel."""

import itertools

import clarabel
import numpy as np
import pytest
from scipy import sparse

from aerodrake.model.qp import condensed_qp as qp
from aerodrake.model.qp.active_set import ActiveSetSolution, solve_active_set
from aerodrake.model.qp.condensed_qp import CondensedQp, QpResult, QpStatus, is_solved

NZ, ROWS = 12, 20


@pytest.fixture
def without_active_set_method(monkeypatch):
    """Makes the active-set method fail, so that only OSQP's iterate is left."""
    monkeypatch.setattr(qp, "solve_active_set", failing)


def failing(program, guess, max_exchanges) -> ActiveSetSolution:
    return ActiveSetSolution(False, program.minimiser, guess)


def random_program(seed: int, pull: float, slack: float):
    """(A, H, g, lower, upper), feasible; `pull` is the size of the unconstrained minimiser."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(ROWS, NZ))
    A /= np.linalg.norm(A, axis=1)[:, None]
    F = rng.normal(size=(NZ, NZ))
    H = F.T @ F + 0.1 * np.eye(NZ)
    g = -H @ rng.uniform(-pull, pull, NZ)
    inside = A @ rng.uniform(-0.5, 0.5, NZ)
    lower = inside - slack * rng.uniform(0.01, 1, ROWS)
    upper = inside + slack * rng.uniform(0.01, 1, ROWS)
    return A, H, g, lower, upper


def solve(A, H, g, lower, upper, max_iterations=20_000) -> QpResult:
    return CondensedQp(A, max_iterations).solve(H, g, lower, upper)


def by_clarabel(A, H, g, lower, upper) -> np.ndarray:
    identity = np.eye(len(g))
    G = np.vstack([A, -A, identity, -identity])
    h = np.concatenate([upper, -lower, np.ones(2 * len(g))])
    finite = np.isfinite(h)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(H)),
        g,
        sparse.csc_matrix(G[finite]),
        h[finite],
        [clarabel.NonnegativeConeT(int(finite.sum()))],
        settings,
    )
    solution = solver.solve()
    assert solution.status == clarabel.SolverStatus.Solved
    return np.array(solution.x)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("pull", "slack"), [(2.0, 0.3), (2.0, 10.0), (0.5, 0.3)])
def test_constrained_optimum(seed, pull, slack):
    program = random_program(seed, pull, slack)
    result = solve(*program)
    assert result.status is QpStatus.EXCHANGED and result.iterations == 0
    np.testing.assert_allclose(result.z, by_clarabel(*program), atol=1e-4)
    # Also from any guess, good or bad.
    qp = CondensedQp(program[0], 20_000)
    for guess in (result.active, np.random.default_rng(seed).integers(-1, 2, NZ + ROWS)):
        again = qp.solve(*program[1:], guess)
        assert again.status is QpStatus.EXCHANGED
        np.testing.assert_array_equal(again.active, result.active)
        np.testing.assert_allclose(again.z, result.z, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_active_set_satisfies_the_optimality_conditions(seed):
    A, H, g, lower, upper = random_program(seed, pull=2.0, slack=0.3)
    result = solve(A, H, g, lower, upper)
    value = np.concatenate([result.z, A @ result.z])
    high, low = np.concatenate([np.ones(NZ), upper]), np.concatenate([-np.ones(NZ), lower])
    np.testing.assert_allclose(value[result.active > 0], high[result.active > 0], atol=1e-7)
    np.testing.assert_allclose(value[result.active < 0], low[result.active < 0], atol=1e-7)
    gradient = H @ result.z + g
    normals = np.vstack([np.eye(NZ), A])[result.active != 0]
    multipliers = np.linalg.lstsq(normals.T, -gradient, rcond=None)[0]
    np.testing.assert_allclose(normals.T @ multipliers, -gradient, atol=1e-6)
    assert np.all(multipliers * result.active[result.active != 0] > -1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_unconstrained_minimiser_is_the_solution_if_no_bound_is_active(seed):
    A, H, g, _, _ = random_program(seed, pull=0.9, slack=1.0)
    free = -np.linalg.solve(H, g)
    lower, upper = A @ free - 0.1, A @ free + 0.1
    result = solve(A, H, g, lower, upper)
    assert result.status is QpStatus.UNCONSTRAINED and result.iterations == 0
    np.testing.assert_allclose(result.z, by_clarabel(A, H, g, lower, upper), atol=1e-6)
    # A bound that excludes it.
    upper[0] = A[0] @ free - 1e-2
    cut = solve(A, H, g, lower, upper)
    assert cut.status is QpStatus.EXCHANGED
    np.testing.assert_allclose(cut.z, by_clarabel(A, H, g, lower, upper), atol=1e-4)


@pytest.mark.parametrize("bound", ["lower", "upper", "box"])
def test_each_kind_of_bound_excludes_the_unconstrained_minimiser(bound):
    A, H, g = np.eye(2), np.eye(2), np.array([0.0, -0.5])
    lower, upper = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
    if bound == "lower":
        lower, expected = np.array([-2.0, 0.8]), [0, 0.8]
    elif bound == "upper":
        upper, expected = np.array([2.0, 0.2]), [0, 0.2]
    else:
        g, expected = np.array([0.0, -3.0]), [0, 1]
    result = solve(A, H, g, lower, upper)
    assert result.status is QpStatus.EXCHANGED
    np.testing.assert_allclose(result.z, expected, atol=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_redundant_constraints_change_nothing(seed):
    """A row that no z in the box violates has the effect of an infinite bound."""
    A, H, g, lower, upper = random_program(seed, pull=2.0, slack=0.3)
    reach = np.abs(A).sum(axis=1)
    loose_lower, loose_upper = lower.copy(), upper.copy()
    loose_lower[::2], loose_upper[::2] = -reach[::2] - 1e-9, reach[::2] + 1e-9
    bounded = solve(A, H, g, loose_lower, loose_upper)
    loose_lower[::2], loose_upper[::2] = -np.inf, np.inf
    unbounded = solve(A, H, g, loose_lower, loose_upper)
    np.testing.assert_array_equal(bounded.z, unbounded.z)
    np.testing.assert_allclose(bounded.z, by_clarabel(A, H, g, loose_lower, loose_upper), atol=1e-4)


def test_infeasible_programs_are_not_solved():
    A, H, g, lower, upper = random_program(0, pull=2.0, slack=0.3)
    A[1] = A[0]
    lower[0], upper[0], lower[1], upper[1] = 0.3, 0.4, -0.4, -0.3
    contradictory = solve(A, H, g, lower, upper)
    lower[0], upper[0] = 50.0, 60.0
    out_of_reach = solve(A, H, g, lower, upper)
    lower[0], upper[0] = 0.1, -0.1
    crossed = solve(A, H, g, lower, upper)
    for result in (contradictory, out_of_reach, crossed):
        assert result.status in (QpStatus.INFEASIBLE, QpStatus.ITERATION_LIMIT)
        np.testing.assert_array_equal(result.z, 0)
    assert crossed.status is QpStatus.INFEASIBLE


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("place", ["H", "g", "lower", "upper"])
def test_nan_or_infinite_inputs_are_not_solved(value, place):
    A, H, g, lower, upper = random_program(0, pull=2.0, slack=0.3)
    program = {"H": H, "g": g, "lower": lower, "upper": upper}
    program[place][0] = -value if place == "upper" else value
    result = solve(A, **program)
    is_bound = place in ("lower", "upper") and np.isinf(value)
    assert result.status is (QpStatus.INFEASIBLE if is_bound else QpStatus.NON_FINITE)
    np.testing.assert_array_equal(result.z, 0)


def test_indefinite_costs_are_not_solved():
    A, H, g, lower, upper = random_program(0, pull=2.0, slack=0.3)
    assert solve(A, H - 1e3 * np.eye(NZ), g, lower, upper).status is QpStatus.NON_FINITE


def test_active_set_from_few_osqp_iterations_is_solved_exactly(monkeypatch):
    """OSQP is called because the first active-set solution is made to fail."""
    calls = itertools.count()

    def every_other(*arguments):
        is_first = next(calls) % 2 == 0
        return (failing if is_first else solve_active_set)(*arguments)

    monkeypatch.setattr(qp, "solve_active_set", every_other)
    for seed in range(40):
        program = random_program(seed, pull=2.0, slack=10.0)
        result = solve(*program, max_iterations=50)
        assert result.status is QpStatus.SOLVED and result.iterations > 0
        np.testing.assert_allclose(result.z, by_clarabel(*program), atol=1e-4)


def test_osqp_iterate_is_used_if_it_is_near_the_optimum(without_active_set_method):
    """Otherwise the status is ITERATION_LIMIT."""
    statuses = set()
    for seed in range(40):
        program = random_program(seed, pull=2.0, slack=10.0)
        result = solve(*program, max_iterations=50)
        statuses.add(result.status)
        assert result.iterations <= 50
        if result.status is QpStatus.INACCURATE:
            np.testing.assert_allclose(result.z, by_clarabel(*program), atol=0.05)
        if result.status is QpStatus.ITERATION_LIMIT:
            np.testing.assert_array_equal(result.z, 0)
    assert statuses == {QpStatus.INACCURATE, QpStatus.ITERATION_LIMIT}


@pytest.mark.parametrize("limit", [1, 40, 2000])
def test_osqp_alone_keeps_its_iteration_limit(limit):
    """Easy programs are not solved otherwise, and an iterate is used if it is near the optimum."""
    statuses = set()
    for seed in range(20):
        A, *program = random_program(seed, pull=2.0, slack=10.0)
        result = CondensedQp(A, 200).solve_by_osqp(*program, limit)
        statuses.add(result.status)
        assert result.iterations <= limit
        if is_solved(result.status):
            np.testing.assert_allclose(result.z, by_clarabel(A, *program), atol=0.05)
    assert (QpStatus.ITERATION_LIMIT in statuses) == (limit < 2000)
    assert (QpStatus.INACCURATE in statuses) == (limit > 1)
    assert statuses <= {QpStatus.INACCURATE, QpStatus.ITERATION_LIMIT}


def test_solutions_stay_in_the_box():
    for seed in range(20):
        result = solve(*random_program(seed, pull=5.0, slack=10.0))
        assert 1 - 1e-9 < np.abs(result.z).max() <= 1.0


def test_solutions_do_not_depend_on_earlier_programs():
    """Even after an infeasible one."""
    A, *program = random_program(1, pull=2.0, slack=0.3)
    _, H, g, _, upper = random_program(2, pull=2.0, slack=0.3)
    qp = CondensedQp(A, 20_000)
    first = qp.solve(*program)
    qp.solve(H, g, upper + 50, upper + 60)
    qp.solve(H, g, np.full(ROWS, -np.inf), np.full(ROWS, np.inf))
    again = qp.solve(*program)
    np.testing.assert_array_equal(first.z, again.z)
    assert (first.status, first.iterations) == (again.status, again.iterations)

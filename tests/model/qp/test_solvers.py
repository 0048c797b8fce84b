"""All solvers on random programs, against the independent minimiser; names in a scenario."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.qp import solvers
from aerodrake.model.qp.quadratic_program import QuadraticProgram
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.qp.solvers import SOLVERS, available_solvers, make_solver
from aerodrake.scenario import Mpc
from aerodrake.support.errors import BadInput
from tests.qp_programs import NZ, ROWS, best, degenerate, infeasible, random_program

SEEDS = st.integers(0, 2**31)
MAX_ITERATIONS = 20_000

each_solver = pytest.mark.parametrize("name", available_solvers())


def solve(name: str, program: QuadraticProgram) -> QpResult:
    return make_solver(name, MAX_ITERATIONS).solve(program)


@each_solver
@given(SEEDS, st.sampled_from([0.2, 0.5, 2.0, 5.0]), st.sampled_from([0.03, 0.3, 10.0]))
def test_solutions_are_exact(name, seed, pull, slack):
    """With none to many active constraints."""
    program = random_program(seed, pull, slack)
    result = solve(name, program)
    assert result.status in (QpStatus.SOLVED, QpStatus.INACCURATE)
    atol = 1e-8 if result.status is QpStatus.SOLVED else 0.05
    np.testing.assert_allclose(result.z, best(program), atol=atol)
    assert np.abs(result.z).max() <= 1.0


@each_solver
@given(SEEDS)
def test_linearly_dependent_constraints(name, seed):
    """The active-set method solves them exactly; the multipliers of others are not unique."""
    program = random_program(seed)
    result = solve(name, degenerate(program))
    exact = result.status is QpStatus.SOLVED
    assert exact or (name != "active_set" and result.status is QpStatus.INACCURATE)
    np.testing.assert_allclose(result.z, best(program), atol=1e-7 if exact else 0.05)


@each_solver
@given(SEEDS)
def test_infeasible_programs_have_no_solution(name, seed):
    program = random_program(seed)
    contradictory = solve(name, infeasible(program))
    upper = program.upper + 50.0
    out_of_reach = solve(name, replace(program, lower=upper - 1.0, upper=upper))
    crossed = solve(name, replace(program, lower=program.upper, upper=program.lower))
    assert crossed.status is QpStatus.INFEASIBLE
    for result in (contradictory, out_of_reach, crossed):
        assert result.status in (QpStatus.INFEASIBLE, QpStatus.ITERATION_LIMIT)
        np.testing.assert_array_equal(result.z, 0)


@each_solver
@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("part", ["H", "g", "A", "lower", "upper"])
def test_nan_or_infinite_inputs_are_refused(name, value, part):
    program = random_program(0)
    values = getattr(program, part).copy()
    values[0] = -value if part == "upper" else value
    result = solve(name, replace(program, **{part: values}))
    is_bound = part in ("lower", "upper") and np.isinf(value)
    assert result.status is (QpStatus.INFEASIBLE if is_bound else QpStatus.NON_FINITE)
    np.testing.assert_array_equal(result.z, 0)


@each_solver
def test_indefinite_costs_are_refused(name):
    program = random_program(0)
    indefinite = replace(program, H=program.H - 1e3 * np.eye(NZ))
    assert solve(name, indefinite).status is QpStatus.NON_FINITE


@each_solver
@pytest.mark.parametrize("bound", ["lower", "upper", "box"])
def test_each_kind_of_bound(name, bound):
    H, g = np.eye(2), np.array([0.0, -0.5])
    lower, upper = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
    if bound == "lower":
        lower, expected = np.array([-2.0, 0.8]), [0, 0.8]
    elif bound == "upper":
        upper, expected = np.array([2.0, 0.2]), [0, 0.2]
    else:
        g, expected = np.array([0.0, -3.0]), [0, 1]
    result = solve(name, QuadraticProgram(H, g, np.eye(2), lower, upper))
    assert result.status is QpStatus.SOLVED
    np.testing.assert_allclose(result.z, expected, atol=1e-12)


@each_solver
def test_solutions_do_not_depend_on_earlier_programs(name):
    """Even of other shapes, without rows, or infeasible."""
    program, solver = random_program(1), make_solver(name, MAX_ITERATIONS)
    first = solver.solve(program)
    solver.solve(infeasible(random_program(2)))
    unbounded = np.full(ROWS, np.inf)
    solver.solve(replace(program, lower=-unbounded, upper=unbounded))
    solver.solve(degenerate(program))
    solver.solve(QuadraticProgram(np.eye(2), np.ones(2), np.eye(2), -np.ones(2), np.ones(2)))
    again = solver.solve(program)
    np.testing.assert_array_equal(first.z, again.z)
    assert first[1:] == again[1:]


@each_solver
@given(SEEDS)
def test_redundant_constraints_change_nothing(name, seed):
    """A bound that no z in the box violates has the effect of an infinite one."""
    program = random_program(seed)
    reach = np.abs(program.A).sum(axis=1)
    lower, upper = program.lower.copy(), program.upper.copy()
    lower[::2], upper[::2] = -reach[::2] - 1e-9, reach[::2] + 1e-9
    bounded = solve(name, replace(program, lower=lower, upper=upper))
    lower[::2], upper[::2] = -np.inf, np.inf
    unbounded = solve(name, replace(program, lower=lower, upper=upper))
    np.testing.assert_array_equal(bounded.z, unbounded.z)


def test_a_scenario_may_name_each_solver():
    key = next(field for field in fields(Mpc) if field.name == "solver")
    assert set(key.metadata["options"]) == set(SOLVERS)
    assert key.default == SOLVERS[0] == "osqp"


def test_a_missing_solver_is_refused_with_the_available_ones(monkeypatch):
    missing = type("Missing", (), {"available": lambda self: True, "enabled": lambda self: False})
    monkeypatch.setattr(solvers, "OTHERS", {**solvers.OTHERS, "mosek": missing})
    names = ", ".join(available_solvers())
    with pytest.raises(BadInput, match=f"no mosek on this machine; available: {names}"):
        make_solver("mosek", 200)

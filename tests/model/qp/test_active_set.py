"""Dual active-set method: number of iterations, vertices and infeasible programs."""

import numpy as np
import pytest

from aerodrake.model.qp.active_set import ActiveSetSolver
from aerodrake.model.qp.quadratic_program import QuadraticProgram
from aerodrake.model.qp.result import QpStatus
from tests.qp_programs import NZ, best, infeasible, random_program


@pytest.mark.parametrize("seed", range(20))
def test_needs_an_iteration_for_each_constraint_that_it_adds(seed):
    program = random_program(seed)
    result = ActiveSetSolver(100).solve(program)
    assert result.status is QpStatus.SOLVED and result.iterations > 0
    again = ActiveSetSolver(result.iterations).solve(program)
    np.testing.assert_array_equal(again.z, result.z)
    fewer = ActiveSetSolver(result.iterations - 1).solve(program)
    assert fewer.status is QpStatus.ITERATION_LIMIT
    np.testing.assert_array_equal(fewer.z, 0)


def test_unconstrained_minimiser_needs_no_iteration():
    program = random_program(0, pull=0.01, slack=100.0)
    result = ActiveSetSolver(100).solve(program)
    assert result.status is QpStatus.SOLVED and result.iterations == 0
    np.testing.assert_allclose(result.z, -np.linalg.solve(program.H, program.g), atol=1e-12)


def test_vertex():
    """As many active constraints as unknowns."""
    corner = np.sign(np.random.default_rng(0).normal(size=NZ))
    none = np.zeros(0)
    program = QuadraticProgram(np.eye(NZ), -5 * corner, np.zeros((0, NZ)), none, none)
    result = ActiveSetSolver(100).solve(program)
    assert result.status is QpStatus.SOLVED
    np.testing.assert_allclose(result.z, corner, atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_infeasible_programs_are_recognised(seed):
    result = ActiveSetSolver(100).solve(infeasible(random_program(seed)))
    assert result.status is QpStatus.INFEASIBLE


def test_constraints_that_others_make_inactive_are_dropped():
    """More are added than are active at the optimum."""
    dropped = 0
    for seed in range(40):
        program = random_program(seed)
        result, z = ActiveSetSolver(100).solve(program), best(program)
        values = np.concatenate([z, program.A @ z])
        lower = np.concatenate([-np.ones(NZ), program.lower])
        upper = np.concatenate([np.ones(NZ), program.upper])
        active = (values > upper - 1e-9) | (values < lower + 1e-9)
        assert result.iterations >= active.sum()
        dropped += result.iterations - active.sum()
    assert dropped > 0

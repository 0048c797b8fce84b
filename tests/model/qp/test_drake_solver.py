"""Scaling of the `MathematicalProgram` that Drake's solvers receive."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.model.qp.drake_solver import ScaledProgram
from aerodrake.model.qp.osqp import make_osqp
from aerodrake.model.qp.quadratic_program import Constraints
from aerodrake.model.qp.result import QpStatus
from tests.qp_programs import NZ, best, random_program


def test_hessian_of_the_dual_has_a_unit_diagonal():
    program = random_program(0)
    constraints, scaled = Constraints.of(program), ScaledProgram.make(NZ)
    factors = scaled.update(program, constraints)
    H, rows = scaled.cost.evaluator().Q(), scaled.rows.evaluator()
    N = rows.GetDenseA()
    np.testing.assert_allclose(np.diag(N @ np.linalg.solve(H, N.T)), 1.0)
    np.testing.assert_allclose(N, factors[:, None] * constraints.N)
    np.testing.assert_allclose(rows.lower_bound(), factors * constraints.lower)
    np.testing.assert_allclose(rows.upper_bound(), factors * constraints.upper)
    np.testing.assert_allclose(H, program.H / program.scale)
    np.testing.assert_allclose(scaled.cost.evaluator().b(), program.g / program.scale)


def test_a_row_of_zeros_is_infeasible_or_without_effect():
    program = random_program(1)
    A, lower, upper = program.A.copy(), program.lower.copy(), program.upper.copy()
    A[0], lower[0], upper[0] = 0.0, -1.0, 1.0
    satisfied = make_osqp(400).solve(replace(program, A=A, lower=lower, upper=upper))
    lower[0] = -np.inf
    upper[0] = np.inf
    without = make_osqp(400).solve(replace(program, A=A, lower=lower, upper=upper))
    np.testing.assert_array_equal(satisfied.z, without.z)
    assert satisfied.status is QpStatus.SOLVED
    lower[0], upper[0] = 0.5, 1.0
    violated = make_osqp(400).solve(replace(program, A=A, lower=lower, upper=upper))
    assert violated.status is QpStatus.INFEASIBLE


@pytest.mark.parametrize("seed", range(20))
def test_osqp_converges_if_the_hessian_is_ill_conditioned(seed):
    rng = np.random.default_rng(seed)
    program = random_program(seed)
    Q, _ = np.linalg.qr(rng.normal(size=(NZ, NZ)))
    H = Q @ np.diag(np.logspace(0, -6, NZ)) @ Q.T
    ill = replace(program, H=(H + H.T) / 2, g=-H @ rng.uniform(-2, 2, NZ))
    result = make_osqp(2000).solve(ill)
    assert result.status is QpStatus.SOLVED
    np.testing.assert_allclose(result.z, best(ill), atol=1e-6)

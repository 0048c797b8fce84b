"""Exact minimiser of a given active set, and the residual of the optimality conditions."""

import numpy as np
import pytest

from aerodrake.model.qp.quadratic_program import Constraints, QuadraticProgram
from aerodrake.model.qp.refinement import estimated_active_set, exact_minimiser, residual
from tests.qp_programs import best, random_program


def optimum(seed: int):
    """Returns a program, its constraints, minimiser, multipliers and active set."""
    program = random_program(seed)
    constraints, z = Constraints.of(program), best(program)
    values = constraints.N @ z
    active = (values > constraints.upper - 1e-9).astype(int) - (values < constraints.lower + 1e-9)
    multipliers = np.zeros(len(active))
    normals = constraints.N[active != 0]
    gradient = (program.H @ z + program.g) / program.scale
    multipliers[active != 0] = np.linalg.lstsq(normals.T, -gradient, rcond=None)[0]
    return program, constraints, z, multipliers, active


@pytest.mark.parametrize("seed", range(20))
def test_minimiser_of_the_active_set(seed):
    program, constraints, z, _, active = optimum(seed)
    np.testing.assert_allclose(exact_minimiser(program, constraints, active), z, atol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_other_active_sets_are_refused(seed):
    """One constraint too few, one on the wrong side, or one too many."""
    program, constraints, z, multipliers, active = optimum(seed)
    strongest, slackest = np.abs(multipliers).argmax(), constraints.violations(z).argmin()
    for index, side in ((strongest, 0), (strongest, -active[strongest]), (slackest, 1)):
        wrong = active.copy()
        wrong[index] = side
        assert exact_minimiser(program, constraints, wrong) is None


@pytest.mark.parametrize("seed", range(20))
def test_linearly_dependent_constraints(seed):
    """Each active constraint twice, and sums of them: multipliers are not unique."""
    program, constraints, z, _, active = optimum(seed)
    indices = np.flatnonzero(active)
    N, lower, upper = (part[indices] for part in constraints)
    sums = Constraints(*(part[:-1] + part[1:] for part in (N, lower, upper)))
    more = Constraints(
        *(np.concatenate(p) for p in zip(constraints, (N, lower, upper), sums, strict=True))
    )
    is_same = active[indices][:-1] == active[indices][1:]  # Else the sum is not active.
    sides = np.concatenate([active, active[indices], is_same * active[indices][1:]])
    np.testing.assert_allclose(exact_minimiser(program, more, sides), z, atol=1e-7)


@pytest.mark.parametrize("seed", range(20))
def test_a_nearly_right_active_set_is_corrected(seed):
    """H is an M-matrix, with bounds on z alone: the method converges from any active set."""
    nz, random = 12, np.random.default_rng(seed)
    H = 2.5 * np.eye(nz) - np.eye(nz, k=1) - np.eye(nz, k=-1)
    none = np.zeros(0)
    program = QuadraticProgram(H, random.normal(size=nz), np.zeros((0, nz)), none, none)
    z, constraints = best(program), Constraints.of(program)
    active = (z > 1 - 1e-6).astype(int) - (z < -1 + 1e-6)
    wrong = active.copy()
    wrong[random.integers(nz)] = 0
    wrong[random.integers(nz)] = 1
    np.testing.assert_allclose(exact_minimiser(program, constraints, wrong), z, atol=1e-6)


def test_contradictory_constraints_are_refused():
    program, constraints, *_, active = optimum(0)
    assert exact_minimiser(program, constraints, np.ones_like(active)) is None


@pytest.mark.parametrize("seed", range(20))
def test_active_set_of_an_approximate_solution(seed):
    _, constraints, z, multipliers, active = optimum(seed)
    near = z + 1e-7 * np.random.default_rng(seed).normal(size=len(z))
    np.testing.assert_array_equal(estimated_active_set(constraints, near, multipliers), active)


@pytest.mark.parametrize("seed", range(5))
def test_residual_is_zero_at_the_optimum_only(seed):
    program, constraints, z, multipliers, _ = optimum(seed)
    assert residual(program, constraints, z, multipliers) < 1e-9
    assert residual(program, constraints, z + 0.01, multipliers) > 1e-4
    assert residual(program, constraints, z, 0 * multipliers) > 1e-4
    assert residual(program, constraints, 1e9 + z, multipliers) > 1e6

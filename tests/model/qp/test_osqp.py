"""OSQP with an iteration limit, with and without refinement of its iterate."""

import numpy as np
import pytest

from aerodrake.model.qp.osqp import make_osqp
from aerodrake.model.qp.result import QpStatus, is_solved
from tests.qp_programs import best, random_program


@pytest.mark.parametrize("limit", [1, 40, 2000])
def test_iterate_is_used_if_it_is_near_the_optimum(limit):
    """Otherwise there is no solution."""
    statuses = set()
    for seed in range(20):
        program = random_program(seed, pull=2.0, slack=10.0)
        result = make_osqp(limit, is_refined=False).solve(program)
        statuses.add(result.status)
        assert 0 < result.iterations <= limit
        if is_solved(result.status):
            np.testing.assert_allclose(result.z, best(program), atol=0.05)
        else:
            np.testing.assert_array_equal(result.z, 0)
    assert (QpStatus.ITERATION_LIMIT in statuses) == (limit < 2000)
    assert (QpStatus.INACCURATE in statuses) == (limit > 1)
    assert statuses <= {QpStatus.INACCURATE, QpStatus.ITERATION_LIMIT}


def test_refinement_makes_a_coarse_iterate_exact():
    coarse = fine = 0.0
    for seed in range(20):
        program = random_program(seed, pull=2.0, slack=10.0)
        iterate = make_osqp(2000, is_refined=False).solve(program)
        refined = make_osqp(2000).solve(program)
        assert refined.status is QpStatus.SOLVED and refined.iterations == iterate.iterations
        coarse = max(coarse, np.abs(iterate.z - best(program)).max())
        fine = max(fine, np.abs(refined.z - best(program)).max())
    assert fine < 1e-9 < 1e-6 < coarse

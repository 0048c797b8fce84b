"""Programs that are spoiled have no answer; where physics asks for it, bounds give way."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.fault import MpcFault, spoiled
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.inputs import MpcInputs
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.qp.condensed_qp import QpStatus
from aerodrake.model.setpoint.integration import SetpointLimits


@pytest.fixture(scope="module")
def formulation(vehicle, tight_scenario) -> MpcFormulation:
    config, model = tight_scenario.mpc, EquivalentModel.of(tight_scenario, vehicle.joints)
    return MpcFormulation(config, model, SetpointLimits.make(config, vehicle), vehicle)


@pytest.fixture(scope="module")
def tick(ticks) -> MpcInputs:
    """The first: at rest, and bounds hold what it plans."""
    return ticks[0]


@pytest.fixture(scope="module")
def solver(formulation) -> MpcSolver:
    return MpcSolver(formulation)


@pytest.mark.parametrize(
    ("fault", "status"),
    [
        (MpcFault.NONE, QpStatus.EXCHANGED),
        (MpcFault.MISSED, QpStatus.EXCHANGED),
        (MpcFault.INFEASIBLE, QpStatus.INFEASIBLE),
        (MpcFault.NON_FINITE, QpStatus.NON_FINITE),
    ],
)
def test_a_spoiled_program_has_no_answer(formulation, solver, tick, fault, status):
    program = formulation.form(tick)
    assert solver.solve(spoiled(program, float(fault))).status is status


def test_one_that_is_starved_has_what_osqp_makes_of_it(formulation, solver, tick):
    program = formulation.form(tick)

    def cost(z: np.ndarray) -> float:
        return z @ program.H @ z / 2 + program.g @ z

    best = cost(solver.solve(program).z)
    assert solver.solve(program, budget=1).status is QpStatus.ITERATION_LIMIT
    near = solver.solve(program, budget=500)
    assert near.status is QpStatus.INACCURATE and near.iterations > 0
    assert best < cost(near.z) < best + 0.02 * abs(best)


def fast(formulation, tick, joint: int, rate: float):
    """The tick with a joint's setpoint that close to its limit that nothing can stop it."""
    x_0 = tick.x_0.copy()
    x_0[formulation.model.joint_velocity[joint]] = rate
    x_0[formulation.model.joint_position[joint]] = formulation.limits.upper[3 + joint] - 1e-3
    return replace(tick, x_0=x_0)


def test_where_no_plan_keeps_the_bounds_it_brakes_as_hard_as_it_can(formulation, solver, tick):
    late = fast(formulation, tick, 0, 2.0)
    program = formulation.form(late)
    result = solver.solve(program)
    assert result.status is QpStatus.RELAXED
    U = formulation.inputs(result.z)
    most = formulation.limits.acceleration[3]
    ticks = int(2.0 / (most * 0.02))  # Whole ones that it takes.
    starts = np.cumsum(formulation.stage_ticks)
    np.testing.assert_allclose(U[starts <= ticks, 3], -most, rtol=1e-3)
    # Bounds that can be kept are kept.
    rows = formulation.A @ result.z
    beyond = (rows > program.upper + 1e-5) | (rows < program.lower - 1e-5)
    relaxed = formulation.relaxed(program)
    widened = (relaxed.upper > program.upper) | (relaxed.lower < program.lower)
    assert beyond.any() and not np.any(beyond & ~widened)


def test_bounds_that_can_be_kept_are_not_relaxed(formulation, tick):
    program = formulation.form(tick)
    relaxed = formulation.relaxed(program)
    np.testing.assert_array_equal(relaxed.lower, program.lower)
    np.testing.assert_array_equal(relaxed.upper, program.upper)

"""MpcSolver: bounds that full braking exceeds are relaxed."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.condensed_qp import QpStatus


@pytest.fixture(scope="module")
def formulation(vehicle, tight_scenario) -> MpcFormulation:
    config, model = tight_scenario.mpc, EquivalentModel.of(tight_scenario, vehicle.joints)
    return MpcFormulation(config, model, vehicle)


@pytest.fixture(scope="module")
def tick(ticks) -> MpcInputs:
    """Inputs of the first tick: at rest, with active constraints."""
    return ticks[0]


@pytest.fixture(scope="module")
def solver(formulation) -> MpcSolver:
    return MpcSolver(formulation)


def fast(formulation, tick, joint: int, rate: float):
    """Returns the tick with a joint's setpoint so close to its limit that it cannot stop."""
    x_0 = tick.x_0.copy()
    x_0[formulation.model.joint_velocity[joint]] = rate
    x_0[formulation.model.joint_position[joint]] = formulation.limits.upper[3 + joint] - 1e-3
    return replace(tick, x_0=x_0)


def test_brakes_at_full_acceleration_if_the_bounds_are_infeasible(formulation, solver, tick):
    late = fast(formulation, tick, 0, 2.0)
    program = formulation.form(late)
    result = solver.solve(program)
    assert result.status is QpStatus.RELAXED
    U = formulation.inputs(result.z)
    most = formulation.limits.acceleration[3]
    ticks = int(2.0 / (most * 0.02))  # Whole ticks of braking.
    starts = np.cumsum(formulation.stage_ticks)
    np.testing.assert_allclose(U[starts <= ticks, 3], -most, rtol=1e-3)
    # Other bounds are not violated.
    rows = formulation.A @ result.z
    beyond = (rows > program.upper + 1e-5) | (rows < program.lower - 1e-5)
    relaxed = formulation.relaxed(program)
    widened = (relaxed.upper > program.upper) | (relaxed.lower < program.lower)
    assert beyond.any() and not np.any(beyond & ~widened)


def test_feasible_bounds_are_not_relaxed(formulation, tick):
    program = formulation.form(tick)
    relaxed = formulation.relaxed(program)
    np.testing.assert_array_equal(relaxed.lower, program.lower)
    np.testing.assert_array_equal(relaxed.upper, program.upper)

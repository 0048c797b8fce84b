"""MpcSolver: relaxed bounds, the shortcut, and the solver of the scenario."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.qp.solver import QpSolver
from aerodrake.model.qp.solvers import available_solvers


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
    return MpcSolver.make(formulation, formulation.config)


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


class Spy(QpSolver):
    """Counts the programs, and solves none."""

    calls = 0

    def _solve(self, program, constraints):
        self.calls += 1
        return QpResult.without_solution(len(program.g), QpStatus.ITERATION_LIMIT)


@pytest.mark.parametrize("has_shortcut", [True, False])
@pytest.mark.parametrize("is_bounded", [True, False])
def test_the_shortcut_accepts_the_minimiser_only_within_the_bounds(
    formulation, tick, has_shortcut, is_bounded
):
    """Otherwise the solver is called, and nothing takes its place if it fails."""
    program = formulation.form(tick)
    if not is_bounded:
        program = replace(program, g=1e-6 * program.g)
    spy = Spy()
    result = MpcSolver(formulation, spy, has_shortcut).solve(program)
    if has_shortcut and not is_bounded:
        assert result.status is QpStatus.UNCONSTRAINED and not spy.calls
        np.testing.assert_allclose(result.z, -np.linalg.solve(program.H, program.g), atol=1e-12)
    else:
        assert result.status is QpStatus.ITERATION_LIMIT
        assert spy.calls == 2  # Also with relaxed bounds.


@pytest.mark.parametrize("name", available_solvers())
def test_every_solver_of_a_scenario_finds_the_same_inputs(formulation, tick, name):
    program = formulation.form(tick)
    config = replace(formulation.config, solver=name, shortcut=False, max_iterations=1000)
    result = MpcSolver.make(formulation, config).solve(program)
    optimum = exact_minimiser(program.H, program.g, program.lower, program.upper, program.A)
    assert optimum.is_constrained and result.status in (QpStatus.SOLVED, QpStatus.INACCURATE)
    if result.status is QpStatus.SOLVED:
        np.testing.assert_allclose(result.z, optimum.z, atol=1e-8)

    def cost(z: np.ndarray) -> float:
        return z @ program.H @ z / 2 + program.g @ z

    assert cost(result.z) == pytest.approx(cost(optimum.z), rel=1e-4)

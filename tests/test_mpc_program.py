"""The MPC's problem on ticks of every packaged scenario, in both of its forms."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver, OsqpSolver, SolverOptions
from pydrake.systems.analysis import Simulator

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import is_solved
from aerodrake.model.qp.solvers import make_solver
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.station import make_closed_loop, make_context
from tests.elimination import assert_same_program

TICKS = 100

FAST = ("clover", "clover_paper", "clover_pointing", "moving_target_paper")
"""Scenarios whose explicit programs OSQP solves by default; with `--long` it solves all."""

TIGHT = {
    ClarabelSolver: {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    OsqpSolver: {
        "eps_abs": 1e-7,
        "eps_rel": 1e-7,
        "polishing": 1,
        "max_iter": 30000,
        "adaptive_rho_interval": 25,  # Automatically it depends on wall time.
    },
}
"""Options with which solvers find u_0 to 1e-4 m/s^2 and rad/s^2 with explicit states."""


@pytest.fixture(scope="module", params=packaged_scenarios())
def recorded(request) -> tuple[MpcFormulation, list[MpcInputs]]:
    """Formulation and inputs of the first ticks of a flight, a fifth of them at hover."""
    scenario = replace(load_scenario(request.param), settle_s=0.4)
    diagram = make_closed_loop(scenario)
    mpc = diagram.GetSubsystemByName("coordinator").GetSubsystemByName("mpc")
    simulator = Simulator(diagram, make_context(diagram, seed=scenario.seed))
    context = mpc.GetMyContextFromRoot(simulator.get_context())
    ticks = []
    for k in range(TICKS):
        simulator.AdvanceTo(k * scenario.rates.mpc_period_s)
        ticks.append(mpc.tick_inputs(context))
    return mpc.formulation, ticks


def test_the_condensed_program_is_the_eliminated_one(recorded):
    formulation, ticks = recorded
    for tick in ticks:
        assert_same_program(formulation.program(tick), formulation.form(tick), formulation)


@pytest.mark.parametrize(("kind", "every"), [(ClarabelSolver, 20), (OsqpSolver, 60)])
def test_solvers_agree_on_the_program_with_explicit_states(kind, every, recorded, request, long):
    if kind is OsqpSolver and not long and request.node.callspec.params["recorded"] not in FAST:
        pytest.skip("OSQP takes a second for the explicit program of a flight model")
    formulation, ticks = recorded
    options = SolverOptions()
    for name, value in TIGHT[kind].items():
        options.SetOption(kind.id(), name, value)
    if kind is OsqpSolver and "b" in formulation.model.axis_states:
        options.SetOption(kind.id(), "sigma", 1e-9)  # The states' sizes are very different.
    for tick in ticks[every - 1 :: every]:
        qp, program = formulation.form(tick), formulation.program(tick)
        best = exact_minimiser(qp.H, qp.g, qp.lower, qp.upper, qp.A)
        result = kind().Solve(program, None, options)
        assert result.is_success()
        u_0 = result.GetSolution(program.u[0])
        np.testing.assert_allclose(u_0, formulation.inputs(best.z)[0], atol=1e-4)


@pytest.mark.parametrize(
    ("name", "accuracy"), [("osqp", 1e-3), ("clarabel", 1e-3), ("active_set", 1e-8)]
)
def test_solvers_agree_on_the_condensed_program(name, accuracy, recorded):
    formulation, ticks = recorded
    solver = make_solver(name, formulation.config.max_iterations)
    for tick in ticks[9::10]:
        qp = formulation.form(tick)
        best = exact_minimiser(qp.H, qp.g, qp.lower, qp.upper, qp.A)
        result = solver.solve(qp)
        assert is_solved(result.status)
        gap = np.abs(formulation.inputs(result.z) - formulation.inputs(best.z))[0].max()
        assert gap < accuracy

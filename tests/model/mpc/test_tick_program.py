"""The problem with explicit states: its text, and its eliminated form against the condensed one."""

import dataclasses

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver, SolverOptions

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import CustomConstraint, CustomCost
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.scenario import Model, Mpc, Scenario
from tests.elimination import assert_same_program

CUSTOM = (
    CustomCost(quantity="joint_position", name="bent", matrix=[[0, 0, 1, 0, 0, 0]], desired=1.0),
    CustomCost(quantity="tool_velocity", name="slow", weight=[1, 2, 3], stages=[1, 4]),
    CustomCost(quantity="input", name="quiet", weight=5.0, stages=[1]),
    CustomConstraint(quantity="tool_position", name="plane", matrix=[[0, 0, 1]], lower=1.1),
    CustomConstraint(
        quantity="base_position", name="box", lower=[-2, -2, 0.5], upper=3, stages=[2]
    ),
    CustomConstraint(quantity="joint_velocity", name="slow", upper=1.0, stages=[1, 2]),
)


def formulation(vehicle, config: Mpc, kind: str = "flight") -> MpcFormulation:
    model = EquivalentModel.of(Scenario(model=Model(kind=kind)), vehicle.joints)
    return MpcFormulation(config, model, vehicle)


@pytest.mark.parametrize("custom", [(), CUSTOM])
@pytest.mark.parametrize(
    ("kind", "tilt", "error", "span"),
    [
        ("flight", "flatness", "predicted", 100),
        ("flight", "none", "frozen", 15),
        ("paper", "held", "predicted", 15),
        ("integral", "none", "predicted", 40),
    ],
)
def test_the_eliminated_form_is_the_condensed_program(
    custom, kind, tilt, error, span, vehicle, ticks_of
):
    config = Mpc(tilt=tilt, error=error, span_ticks=span)
    ours = formulation(vehicle, config, kind).extended(*custom)
    for tick in ticks_of(ours.model)[::40]:
        tick = dataclasses.replace(tick, delta=np.array([0.1, -0.2, 0.05]))
        assert_same_program(ours.program(tick), ours.form(tick), ours)


@pytest.mark.parametrize("custom", [(), CUSTOM[:3]])
def test_any_solver_of_drake_finds_the_same_inputs(custom, tight_scenario, vehicle, ticks_of):
    ours = formulation(vehicle, tight_scenario.mpc, "velocity_aware").extended(*custom)
    for tick in ticks_of(ours.model)[::60]:
        condensed = ours.form(tick)
        best = exact_minimiser(
            condensed.H, condensed.g, condensed.lower, condensed.upper, condensed.A
        )
        program = ours.program(tick)
        options = SolverOptions()
        for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
            options.SetOption(ClarabelSolver.id(), name, 1e-12)
        result = ClarabelSolver().Solve(program, None, options)
        assert result.is_success()
        np.testing.assert_allclose(result.GetSolution(program.u), ours.inputs(best.z), atol=1e-3)


def test_the_text_of_two_stages_is_one_page(vehicle, ticks):
    ours = formulation(vehicle, Mpc(horizon=2, span_ticks=3), "paper").extended(CUSTOM[0])
    tick = dataclasses.replace(ticks[0], x_0=np.zeros(24), reference=ticks[0].reference[:3])
    text = str(ours.program(tick))
    lines = text.splitlines()
    assert len(lines) < 60 and max(map(len, lines)) < 120
    costs, constraints = text.split("subject to")
    for name in ("J_1", "J_2", "J_3", "J_4", "J_5", "bent"):
        assert costs.count(f"  {name}[") == 2
    assert "x[2] = A x[1] + B u[1] + C Delta over 2 ticks" in constraints
    assert "x[0] = x_init" in constraints and "u[1] in U" in constraints


def test_variables_have_the_symbols_of_the_paper(vehicle, ticks):
    program = formulation(vehicle, Mpc(horizon=3, span_ticks=3)).program(
        dataclasses.replace(ticks[0], reference=ticks[0].reference[:4])
    )
    names = [variable.get_name() for variable in program.decision_variables()]
    assert len(set(names)) == len(names)
    assert {"p_Bx[0]", "p_By,d'[3]", "q_6'[1]", "p_Bz,d''[2]", "q_1''[0]", "p_Ez[1]"} <= set(names)
    assert str(program.quantity("tool_position", 2)[0]) == "p_Ex[2]"

"""The condensed MPC against the paper's problem with explicit states, solved by Clarabel."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import linprog

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.horizon import StageResponses
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.active_set import ActiveSetSolver
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Model, Mpc, Scenario
from tests.explicit_mpc import K_B, ExplicitMpc, acceleration, displacement

DT = 0.02
OPTIONS = [
    # Model, e_E, roll and pitch, ticks of the horizon.
    ("flight", "frozen", "flatness", 20),
    ("velocity_aware", "predicted", "none", 15),
    ("velocity_aware", "frozen", "held", 25),
    ("integral", "predicted", "none", 15),
    ("integral", "frozen", "none", 15),
    ("paper", "predicted", "flatness", 15),
    ("exact", "frozen", "flatness", 30),
    ("exact", "predicted", "held", 15),
]


def make_model(kind: str, vehicle: VehicleModel) -> EquivalentModel:
    return EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=tuple(K_B))), vehicle.joints)


def formulation(
    config: Mpc, vehicle: VehicleModel, kind: str, error: str, tilt: str, span: int
) -> MpcFormulation:
    """Returns the formulation under test, with different weights for all axes and joints."""
    config = dataclasses.replace(
        config,
        error=error,
        tilt=tilt,
        span_ticks=span,
        w_5=(3.0, 20.0, 150.0),
        k_e=(3.0, 2.0, 4.0),
        w_1=(1e4, 2e4, 0.5e4),
        w_2_base=(1e-2, 2e-2, 3e-2),
        w_2_joints=(1e-2, 2e-2, 1e-3, 3e-2, 2e-3, 1e-2),
        w_3_base=(30.0, 20.0, 40.0),
        w_3_joints=(10.0, 12.0, 8.0, 15.0, 9.0, 11.0),
        w_4=(300.0, 200.0, 400.0),
    )
    return MpcFormulation(config, make_model(kind, vehicle), vehicle)


@pytest.fixture(scope="module")
def prepared(ticks_of):
    """Returns a function that makes the ticks of a model, with a residual.

    Models that start from the command get the commanded base.
    """

    def prepared(model: EquivalentModel) -> list[MpcInputs]:
        made = []
        for k, tick in enumerate(ticks_of(model)):
            if model.base_is_commanded:
                tick.x_0[[0, 1, 4, 5, 8, 9]] = tick.x_0[[2, 3, 6, 7, 10, 11]]
            delta = 0.05 * np.random.default_rng(k).normal(size=3)
            made.append(dataclasses.replace(tick, delta=delta))
        return made

    return prepared


@pytest.mark.parametrize("option", OPTIONS)
def test_optimum_is_that_of_the_explicit_problem(option, prepared, tight_scenario, vehicle):
    """At every eighth tick of a flight with active bounds: over 100 programs in all."""
    ours = formulation(tight_scenario.mpc, vehicle, *option)
    solver = ActiveSetSolver(ours.config.max_iterations)
    theirs = ExplicitMpc(ours.config, ours.model, vehicle)
    statuses, active, gaps = [], [], []
    for tick in prepared(ours.model)[::8]:
        program = ours.form(tick)
        result = solver.solve(program)
        u_0, active_fraction = theirs.solve(tick)
        statuses.append(result.status)
        active.append(active_fraction)
        gaps.append(np.abs(ours.inputs(result.z)[0] - u_0).max())
        if not theirs.is_exact:  # Then ours is feasible and has a lower cost.
            costs = [
                z @ program.H @ z / 2 + program.g @ z
                for z in (result.z, theirs.U.T.ravel() / ours.scale)
            ]
            assert costs[0] <= costs[1] + 1e-9
            assert np.all(ours.A @ result.z <= program.upper + 1e-9)
            assert np.all(ours.A @ result.z >= program.lower - 1e-9)
            gaps.pop()
    assert len(OPTIONS) * len(statuses) > 100 and len(gaps) > len(statuses) / 2
    assert np.max(gaps) < 1e-5
    assert set(statuses) == {QpStatus.SOLVED}
    assert np.mean(np.array(active) > 0) > 0.5


@pytest.mark.parametrize("option", OPTIONS[:3])
def test_prediction_of_the_program_equals_the_model(option, prepared, tight_scenario, vehicle):
    """At all stages; p_E by J_s and tilt from the measured one."""
    ours = formulation(tight_scenario.mpc, vehicle, *option)
    model, tick = ours.model, prepared(ours.model)[50]
    u = np.random.default_rng(0).normal(size=(ours.config.horizon, 3 + vehicle.joints))
    free = driven = tick.x_0
    program, at = ours.form(tick), tick.end_effector
    p_E = ours.predict(tick, program, u)
    for k, ticks in enumerate(ours.stage_ticks):
        for _ in range(ticks):
            free = model.predict(free, np.zeros_like(u[k]), tick.delta)
            driven = model.predict(driven, u[k], tick.delta)
        positions = [*model.base_position, *model.joint_position]
        m = len(positions)
        np.testing.assert_allclose(
            program.free_response[m : 2 * m, k], (free - tick.x_0)[positions], atol=1e-12
        )
        moved = driven - tick.x_0
        position = moved[model.base_position] + at.J_c[:, 4:] @ moved[model.joint_position]
        if ours.config.tilt == "flatness":
            position = position + displacement(at.r, acceleration(model, moved))
        np.testing.assert_allclose(p_E[k + 1], at.p_E + position, atol=1e-10)
    np.testing.assert_array_equal(p_E[0], at.p_E)


def test_one_weight_applies_to_all_joints(tight_scenario, ticks, vehicle):
    config = tight_scenario.mpc
    per_joint = dataclasses.replace(
        config, w_2_joints=config.w_2_joints * 6, w_3_joints=config.w_3_joints * 6
    )
    model = make_model("flight", vehicle)
    for name in ("H", "g"):
        one, other = (
            getattr(MpcFormulation(c, model, vehicle).form(ticks[0]), name)
            for c in (config, per_joint)
        )
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("horizon", [10, 15])
def test_feasibility_is_recursive(horizon, ticks_of, vehicle):
    """Even if plans maximise the speed towards the upper limits of the joints.

    A joint can stop within the horizons: v_max / a_max = 10 ticks and more.
    """
    config, model = Mpc(horizon=horizon, span_ticks=horizon), make_model("velocity_aware", vehicle)
    ours = MpcFormulation(config, model, vehicle)
    first = ticks_of(model)[0]
    tick = dataclasses.replace(first, reference=np.zeros((horizon + 1, 6)), delta=np.zeros(3))
    responses = StageResponses(model, ours.stage_ticks, ours.limits.acceleration)
    by_input = responses.Gamma[:, model.joint_velocity].sum(axis=(0, 1))
    speeds = by_input.reshape(horizon, -1).T.ravel() * ours.scale
    x = tick.x_0.copy()
    x[model.joint_position] = vehicle.upper - 0.8
    for k in range(35):
        program = ours.form(dataclasses.replace(tick, x_0=x))
        plan = linprog(
            -speeds,
            A_ub=np.vstack([ours.A, -ours.A]),
            b_ub=np.concatenate([program.upper, -program.lower]) + 1e-9,
            bounds=(-1, 1),
        )
        assert plan.status == 0, f"infeasible at tick {k}"
        x = model.predict(x, ours.inputs(plan.x)[0], tick.delta)
    to_limit = vehicle.upper - x[model.joint_position]
    assert np.all(to_limit >= -1e-6) and np.all(to_limit < 0.2)

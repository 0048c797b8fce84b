"""Costs and constraints of one's own: what they add, and which are refused."""

import dataclasses

import numpy as np
import pytest

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import CustomConstraint, CustomCost
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.qp.solvers import make_solver
from aerodrake.support.errors import BadInput


@pytest.fixture(scope="module")
def formulation(vehicle, tight_scenario) -> MpcFormulation:
    model = EquivalentModel.of(tight_scenario, vehicle.joints)
    return MpcFormulation(tight_scenario.mpc, model, vehicle)


def optimum(formulation, tick) -> np.ndarray:
    """Returns the best inputs (N, m)."""
    qp = formulation.form(tick)
    return formulation.inputs(exact_minimiser(qp.H, qp.g, qp.lower, qp.upper, qp.A).z)


def flown(formulation, tick, U) -> np.ndarray:
    """Returns the states (N, nx) at the ends of the stages, by the model."""
    x, states = tick.x_0, []
    for u, ticks in zip(U, formulation.stage_ticks, strict=True):
        for _ in range(ticks):
            x = formulation.model.predict(x, u, tick.delta)
        states.append(x)
    return np.array(states)


def test_a_cost_pulls_a_joint_to_its_desired_angle(formulation, ticks):
    elbow = formulation.model.joint_position[2]
    near = CustomCost(
        quantity="joint_position",
        name="elbow",
        matrix=[[0, 0, 1, 0, 0, 0]],
        desired=ticks[0].x_0[elbow] + 0.3,
        weight=1e9,
    )
    extended = formulation.extended(near)
    states = flown(extended, ticks[0], optimum(extended, ticks[0]))
    assert states[-1, elbow] == pytest.approx(near.desired, abs=1e-3)
    without = flown(formulation, ticks[0], optimum(formulation, ticks[0]))
    assert abs(without[-1, elbow] - near.desired) > 0.1


@pytest.mark.parametrize("stages", [None, [3, 15]])
def test_a_constraint_binds_at_its_stages_only(formulation, ticks, stages):
    x = formulation.model.base_position[0]
    free = flown(formulation, ticks[80], optimum(formulation, ticks[80]))[:, x]
    bound = (free.min() + free.max()) / 2
    side = {"upper": bound} if free[-1] > bound else {"lower": bound}
    box = CustomConstraint(
        quantity="base_position",
        name="box",
        matrix=[[1, 0, 0]],
        stages=stages,
        time_constant_s=0.0,
        **side,
    )
    extended = formulation.extended(box)
    held = flown(extended, ticks[80], optimum(extended, ticks[80]))[:, x]
    sign = 1 if "upper" in side else -1
    index = np.arange(15) if stages is None else np.array(stages) - 1
    assert np.all(sign * (held[index] - bound) < 1e-9)
    assert np.max(sign * (held[index] - bound)) > -1e-6  # It is active.


def test_a_tool_constraint_bounds_the_prediction(formulation, ticks):
    tick = ticks[60]
    p_E = formulation.predict(tick, formulation.form(tick), optimum(formulation, tick))
    lowest = p_E[:, 2].min() + 0.002
    above = CustomConstraint(
        quantity="tool_position",
        name="above",
        matrix=[[0, 0, 1]],
        lower=lowest,
        stages=range(8, 16),
        time_constant_s=0.0,
    )
    extended = formulation.extended(above)
    U = optimum(extended, tick)
    assert extended.predict(tick, extended.form(tick), U)[8:, 2].min() == pytest.approx(
        max(lowest, p_E[8:, 2].min()), abs=1e-4
    )


def test_terms_add_up_and_leave_the_formulation_alone(formulation, ticks):
    slow = CustomCost(quantity="joint_velocity", name="slow", weight=2.0)
    quiet = CustomCost(quantity="input", name="quiet", weight=3.0)
    rows, H = formulation.form(ticks[0]).A.shape[0], formulation.form(ticks[0]).H
    both = formulation.extended(slow).extended(quiet).form(ticks[0])
    at_once = formulation.extended(slow, quiet).form(ticks[0])
    np.testing.assert_array_equal(both.H, at_once.H)
    assert formulation.form(ticks[0]).A.shape[0] == rows
    np.testing.assert_array_equal(formulation.form(ticks[0]).H, H)
    diagonal = formulation.extended(quiet).form(ticks[0]).H - H
    ticks_of_z = np.tile(formulation.stage_ticks, len(formulation.objective.W_3))
    np.testing.assert_allclose(
        diagonal, np.diag(3.0 * ticks_of_z * formulation.scale**2), atol=1e-6
    )


def test_an_infeasible_constraint_gets_the_least_violation(formulation, ticks):
    """The base cannot be 1 m higher at once; it rises as fast as it can."""
    tick, z_B = ticks[0], formulation.model.base_position[2]
    up = CustomConstraint(
        quantity="base_position",
        name="up",
        matrix=[[0, 0, 1]],
        lower=tick.x_0[z_B] + 1.0,
        stages=[15],
        time_constant_s=0.0,
    )
    extended = formulation.extended(up)
    program = extended.form(tick)
    with pytest.raises(ValueError, match="infeasible"):
        exact_minimiser(program.H, program.g, program.lower, program.upper, program.A)
    result = MpcSolver(extended, make_solver("active_set", 200)).solve(program)
    assert result.status is QpStatus.SOFTENED
    reached = flown(extended, tick, extended.inputs(result.z))[-1, z_B]
    # The fastest climb within the limits of the setpoint's acceleration and velocity.
    limits, speed, climb = formulation.limits, 0.0, np.zeros((15, 9))
    for u, stage_s in zip(climb, formulation.stage_ticks * formulation.model.dt, strict=True):
        u[2] = min(limits.acceleration[2], (limits.velocity[2] - speed) / stage_s)
        speed += u[2] * stage_s
    fastest = flown(extended, tick, climb)[-1, z_B]
    assert reached == pytest.approx(fastest, abs=1e-3)


def test_bounds_of_the_vehicle_have_no_slack(formulation, ticks):
    stop = CustomConstraint(quantity="base_velocity", name="fast", lower=5.0)
    program = formulation.extended(stop).form(ticks[0])
    least = formulation.extended(stop).least_violation(formulation.relaxed(program))
    assert len(least.g) == len(program.g) + 3 * 15
    assert np.abs(least.A[: len(formulation.A), len(program.g) :]).max() == 0
    np.testing.assert_allclose(np.linalg.norm(least.A, axis=1), 1.0)


def test_the_rate_keeps_a_distance_from_the_bound(formulation, ticks):
    """x approaches its bound as exp(-t / tau): x + tau x' stays within."""
    tick, tau = ticks[80], 0.5
    x, v = formulation.model.base_position[0], formulation.model.base_velocity[0]
    free = flown(formulation, tick, optimum(formulation, tick))
    side = 1 if free[-1, x] > free[0, x] else -1
    bound = free[:, x].mean()
    limits = {"upper": bound} if side > 0 else {"lower": bound}
    box = CustomConstraint(
        quantity="base_position", name="box", matrix=[[1, 0, 0]], time_constant_s=tau, **limits
    )
    extended = formulation.extended(box)
    states = flown(extended, tick, optimum(extended, tick))
    assert np.all(side * (states[:, x] + tau * states[:, v] - bound) < 1e-9)
    assert np.max(side * (states[:, x] + tau * states[:, v] - bound)) > -1e-6


@pytest.mark.parametrize(
    ("term", "message"),
    [
        ({"quantity": "tool_positon"}, "did you mean 'tool_position'"),
        ({"matrix": [[1, 0]]}, r"matrix: expected shape \(d, 3\), got \(1, 2\)"),
        ({"matrix": [[1, 0, float("nan")]]}, "matrix: expected finite numbers"),
        ({"stages": [0]}, r"stages: expected integers from 1 to 15, got \[0\]"),
        ({"stages": [1.5]}, "stages: expected integers"),
        ({"stages": []}, "stages: expected integers"),
        ({"stages": [[1], [2, 3]]}, "stages: expected integers"),
        ({"quantity": ["tool_position"]}, "quantity: got"),
        ({"stages": 5}, "stages: expected integers"),
        ({"weight": -1.0}, "weight: expected 0 to 1e9"),
        ({"weight": 1e10}, "weight: expected 0 to 1e9"),
        ({"weight": [1, 2]}, r"weight: expected one number or 3, got shape \(2,\)"),
        ({"desired": "high"}, "desired: expected numbers"),
        ({"desired": float("inf")}, "desired: expected finite numbers"),
    ],
)
def test_terms_that_do_not_fit_are_refused(formulation, term, message):
    arguments = {"quantity": "tool_position", "name": "mine"} | term
    with pytest.raises(BadInput, match=f"CustomCost 'mine': .*{message}|{message}"):
        formulation.extended(CustomCost(**arguments))


def test_crossed_bounds_are_refused(formulation):
    crossed = CustomConstraint(quantity="tool_position", name="mine", lower=1.0, upper=[2, 0, 2])
    with pytest.raises(BadInput, match="lower: expected no more than upper"):
        formulation.extended(crossed)


@pytest.mark.parametrize(("key", "bound"), [("lower", float("inf")), ("upper", -float("inf"))])
def test_infinite_bounds_on_the_wrong_side_are_refused(formulation, key, bound):
    never = CustomConstraint(quantity="tool_position", name="mine", **{key: bound})
    with pytest.raises(BadInput, match=f"{key}: expected numbers"):
        formulation.extended(never)


def test_other_objects_are_refused(formulation):
    above = CustomConstraint(quantity="tool_position", name="mine", lower=1.0)
    with pytest.raises(BadInput, match="expected CustomCost or CustomConstraint, got list"):
        formulation.extended([above])


@pytest.mark.parametrize("size", [0.0, 1e-14])
@pytest.mark.parametrize("lower", [-1.0, 1.0])
def test_rows_without_effect_change_nothing(formulation, ticks, size, lower):
    term = CustomConstraint(
        quantity="base_position", name="none", matrix=[[size, 0, 0]], lower=lower
    )
    extended = formulation.extended(term)
    result = MpcSolver.make(extended, extended.config).solve(extended.form(ticks[80]))
    free = MpcSolver.make(formulation, formulation.config).solve(formulation.form(ticks[80]))
    assert result.status is (free.status if lower < 0 else QpStatus.SOFTENED)
    np.testing.assert_allclose(result.z, free.z, atol=1e-3)


IMPOSSIBLE = {
    "far above": {"quantity": "tool_position", "matrix": [[0, 0, 1]], "lower": 5.0},
    "far away at once": {"quantity": "base_position", "lower": 5.0, "time_constant_s": 0.0},
    "bent at once": {"quantity": "joint_position", "matrix": [[0, 0, 1, 0, 0, 0]], "upper": 0.5},
    "beyond the motors": {"quantity": "input", "lower": 1e3},
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
@pytest.mark.parametrize("solver", ["osqp", "active_set", "clarabel"])
def test_every_solver_softens_what_is_impossible(formulation, ticks, name, solver):
    extended = formulation.extended(CustomConstraint(name=name, **IMPOSSIBLE[name]))
    for tick in (ticks[0], ticks[80]):
        result = MpcSolver(extended, make_solver(solver, 400)).solve(extended.form(tick))
        assert result.status is QpStatus.SOFTENED


@pytest.mark.parametrize("tau", [-0.1, 11.0, float("nan"), "slow", [0.1, 0.2]])
def test_time_constants_out_of_range_are_refused(formulation, tau):
    box = CustomConstraint(quantity="base_position", name="mine", upper=2.0, time_constant_s=tau)
    with pytest.raises(BadInput, match="time_constant_s: expected"):
        formulation.extended(box)


def test_the_axis_needs_an_orientation_task(formulation, ticks):
    tilted = CustomCost(quantity="tool_axis", name="down", desired=[0, 0, -1])
    without = dataclasses.replace(ticks[0], pointing=None)
    with pytest.raises(BadInput, match="orientation"):
        formulation.extended(tilted).form(without)

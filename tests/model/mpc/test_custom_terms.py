"""Costs and constraints of one's own: what they add, and which are refused."""

import dataclasses

import numpy as np
import pytest

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import CustomConstraint, CustomCost
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.support.errors import BadInput


@pytest.fixture(scope="module")
def formulation(vehicle, tight_scenario) -> MpcFormulation:
    model = EquivalentModel.of(tight_scenario, vehicle.joints)
    return MpcFormulation(tight_scenario.mpc, model, vehicle)


def optimum(formulation, tick) -> np.ndarray:
    """Returns the best inputs (N, m)."""
    qp = formulation.form(tick).qp
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
        quantity="base_position", name="box", matrix=[[1, 0, 0]], stages=stages, **side
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
    )
    extended = formulation.extended(above)
    U = optimum(extended, tick)
    assert extended.predict(tick, extended.form(tick), U)[8:, 2].min() == pytest.approx(
        max(lowest, p_E[8:, 2].min()), abs=1e-4
    )


def test_terms_add_up_and_leave_the_formulation_alone(formulation, ticks):
    slow = CustomCost(quantity="velocity", name="slow", weight=2.0)
    quiet = CustomCost(quantity="input", name="quiet", weight=3.0)
    rows, H = formulation.form(ticks[0]).A.shape[0], formulation.form(ticks[0]).H
    both = formulation.extended(slow).extended(quiet).form(ticks[0])
    at_once = formulation.extended(slow, quiet).form(ticks[0])
    np.testing.assert_array_equal(both.H, at_once.H)
    assert formulation.form(ticks[0]).A.shape[0] == rows
    np.testing.assert_array_equal(formulation.form(ticks[0]).H, H)
    diagonal = formulation.extended(quiet).form(ticks[0]).H - H
    ticks_of_z = np.tile(formulation.stage_ticks, len(formulation.W_3))
    np.testing.assert_allclose(
        diagonal, np.diag(3.0 * ticks_of_z * formulation.scale**2), atol=1e-6
    )


def test_an_infeasible_constraint_gets_the_least_violation(formulation, ticks):
    """The base cannot be 1 m higher at once; it rises as fast as it can."""
    tick = ticks[0]
    z_0 = tick.x_0[formulation.model.base_position[2]]
    up = CustomConstraint(
        quantity="base_position", name="up", matrix=[[0, 0, 1]], lower=z_0 + 1.0, stages=[15]
    )
    extended = formulation.extended(up)
    program = extended.form(tick)
    with pytest.raises(ValueError, match="infeasible"):
        exact_minimiser(*(program.H, program.g, program.lower, program.upper, program.A))
    soft = extended.softened(program)
    assert len(soft.g) == len(program.g) + 1
    z = exact_minimiser(soft.H, soft.g, soft.lower, soft.upper, soft.A).z
    states = flown(extended, tick, extended.inputs(z[: len(program.g)]))
    fastest = np.concatenate([[0, 0, 1], np.zeros(6)]) * formulation.limits.acceleration
    climb = flown(extended, tick, np.tile(fastest, (15, 1)))[:, formulation.model.base_position[2]]
    reached = states[-1, formulation.model.base_position[2]]
    assert z_0 + 0.4 < reached < min(z_0 + 1.0, climb[-1])


def test_bounds_of_the_vehicle_are_not_softened(formulation, ticks):
    stop = CustomConstraint(quantity="velocity", name="stop", lower=5.0)
    program = formulation.extended(stop).form(ticks[0])
    soft = formulation.extended(stop).softened(program)
    rows = len(formulation.A)
    assert np.abs(soft.A[:rows, len(program.g) :]).max() == 0
    np.testing.assert_allclose(np.linalg.norm(soft.A, axis=1), 1.0)


@pytest.mark.parametrize(
    ("term", "message"),
    [
        ({"quantity": "tool_positon"}, "did you mean 'tool_position'"),
        ({"matrix": [[1, 0]]}, r"matrix: expected shape \(d, 3\), got \(1, 2\)"),
        ({"matrix": [[1, 0, float("nan")]]}, "matrix: expected finite numbers"),
        ({"stages": [0]}, r"stages: expected integers from 1 to 15, got \[0\]"),
        ({"stages": [1.5]}, "stages: expected integers"),
        ({"stages": []}, "stages: expected integers"),
        ({"weight": -1.0}, "weight: expected 0 or more"),
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


def test_the_axis_needs_an_orientation_task(formulation, ticks):
    tilted = CustomCost(quantity="tool_axis", name="down", desired=[0, 0, -1])
    without = dataclasses.replace(ticks[0], pointing=None)
    with pytest.raises(BadInput, match="orientation"):
        formulation.extended(tilted).form(without)

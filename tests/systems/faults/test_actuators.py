"""Faults between actuators and plant: start and end, combinations, and invalid indices."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.scenario import JointDegraded, Push, RotorDegraded, Scenario
from aerodrake.support.errors import BadInput
from aerodrake.systems.faults.actuators import make_joint_faults, make_pushes, make_rotor_faults

SETTLE_S = 3.0
THRUST = np.array([9.0, 8.0, 7.0, 6.0])


def scenario(*faults) -> Scenario:
    return replace(Scenario(), settle_s=SETTLE_S, faults=faults, source="flight.yaml")


def output_at(system, value, reference_s: float) -> np.ndarray:
    """Returns the output of a system for an input at a reference time."""
    context = system.CreateDefaultContext()
    context.SetTime(SETTLE_S + reference_s)
    system.get_input_port().FixValue(context, value)
    return system.get_output_port().Eval(context)


def force_at(pushes, reference_s: float) -> np.ndarray:
    """Returns the generalized force of pushes at a reference time."""
    context = pushes.CreateDefaultContext()
    context.SetTime(SETTLE_S + reference_s)
    return pushes.get_output_port().Eval(context)


def test_without_faults_of_actuators_there_are_no_systems():
    others = scenario(Push())
    assert make_rotor_faults(others, 4) is None
    assert make_joint_faults(others, 6) is None


def test_without_pushes_the_force_is_zero():
    np.testing.assert_array_equal(
        force_at(make_pushes(scenario(RotorDegraded()), 6), 1.0), [0] * 12
    )


@pytest.mark.parametrize("start", [-2.0, 0.0, 1.234])
def test_a_fault_lasts_from_its_start_until_before_its_end(start):
    """To the plant step: instants that differ by rounding count."""
    system = make_rotor_faults(scenario(RotorDegraded(start, 0.5, rotor=1, remaining=0.25)), 4)
    healthy, degraded = THRUST, THRUST * [1, 0.25, 1, 1]
    for time, expected in (
        (start - 1e-3, healthy),
        (start - 1e-12, degraded),
        (start, degraded),
        (start + 0.499, degraded),
        (start + 0.5 - 1e-12, healthy),
        (start + 0.5, healthy),
    ):
        np.testing.assert_array_equal(output_at(system, THRUST, time), expected)


def test_faults_of_one_rotor_multiply_and_other_rotors_are_unaffected():
    system = make_rotor_faults(
        scenario(
            Push(),
            RotorDegraded(0.0, 10.0, rotor=2, remaining=0.5),
            RotorDegraded(5.0, 10.0, rotor=2, remaining=0.8),
            RotorDegraded(5.0, 10.0, rotor=0, remaining=0.0),
        ),
        4,
    )
    np.testing.assert_allclose(output_at(system, THRUST, 1.0), THRUST * [1, 1, 0.5, 1])
    np.testing.assert_allclose(output_at(system, THRUST, 6.0), THRUST * [0, 1, 0.4, 1])
    np.testing.assert_allclose(output_at(system, THRUST, 11.0), THRUST * [0, 1, 0.8, 1])


def test_joints():
    torque = np.array([1.0, -2.0, 3.0])
    system = make_joint_faults(scenario(JointDegraded(0.0, 1.0, joint=1, remaining=0.2)), 3)
    np.testing.assert_allclose(output_at(system, torque, 0.5), [1.0, -0.4, 3.0])
    np.testing.assert_array_equal(output_at(system, torque, 2.0), torque)


def test_pushes_add_up():
    system = make_pushes(
        scenario(Push(0.0, 2.0, (1.0, 2.0, 3.0)), Push(1.0, 2.0, (-5.0, 0.0, 0.0))), 2
    )
    for time, force in ((0.5, [1, 2, 3]), (1.5, [-4, 2, 3]), (2.5, [-5, 0, 0]), (3.5, [0, 0, 0])):
        np.testing.assert_array_equal(force_at(system, time), [0, 0, 0, *force, 0, 0])


def test_faults_have_no_delay():
    for system in (
        make_rotor_faults(scenario(RotorDegraded()), 4),
        make_joint_faults(scenario(JointDegraded()), 6),
    ):
        assert system.HasAnyDirectFeedthrough()
        assert system.num_continuous_states() == 0
        assert system.CreateDefaultContext().num_discrete_state_groups() == 0


@pytest.mark.parametrize(
    ("make", "fault", "count", "expected"),
    [
        (make_rotor_faults, RotorDegraded(rotor=4), 4, r"faults\[1\]\.rotor: .* \[0, 3\], got 4"),
        (make_joint_faults, JointDegraded(joint=6), 6, r"faults\[1\]\.joint: .* \[0, 5\], got 6"),
    ],
)
def test_an_index_that_the_robot_does_not_have_raises(make, fault, count, expected):
    with pytest.raises(BadInput, match="^flight.yaml: " + expected):
        make(scenario(Push(), fault), count)

"""Faults between actuators and plant, and pushes, as systems of Drake's own."""

from collections.abc import Sequence

import numpy as np
from pydrake.symbolic import Expression, Variable, if_then_else, logical_and
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.scenario import Fault, JointDegraded, Push, RotorDegraded, Scenario
from aerodrake.support.errors import ScenarioError

ROUNDING_S = 1e-9
"""Tolerance of the instants at which a fault begins and ends: times of plant steps are rounded."""


def make_rotor_faults(scenario: Scenario, rotors: int) -> SymbolicVectorSystem | None:
    """Makes the system that reduces the thrusts of degraded rotors; None if there are none.

    Ports:
        in `u0` (k): N, thrusts after lag and limits.
        out `y0` (k): N, thrusts times the remaining fractions of all active faults.

    Args:
        scenario: Its faults, which begin and end at reference times.
        rotors: k.

    Raises:
        ScenarioError: if a fault's rotor does not exist.
    """
    remaining = {
        i: (fault.rotor, fault.remaining)
        for i, fault in enumerate(scenario.faults)
        if isinstance(fault, RotorDegraded)
    }
    return _degraded(scenario, remaining, "rotor", rotors)


def make_joint_faults(scenario: Scenario, joints: int) -> SymbolicVectorSystem | None:
    """Makes the system that reduces the torques of degraded motors; None if there are none.

    Ports:
        in `u0` (n): N m, commanded torques.
        out `y0` (n): N m, torques times the remaining fractions of all active faults.

    Args:
        scenario: Its faults, which begin and end at reference times.
        joints: n.

    Raises:
        ScenarioError: if a fault's joint does not exist.
    """
    remaining = {
        i: (fault.joint, fault.remaining)
        for i, fault in enumerate(scenario.faults)
        if isinstance(fault, JointDegraded)
    }
    return _degraded(scenario, remaining, "joint", joints)


def make_pushes(scenario: Scenario, joints: int) -> SymbolicVectorSystem | None:
    """Makes the system that adds pushes on the base to other forces; None if there are none.

    Ports:
        in `u0` (6 + n): generalized force on the plant's velocities [omega_W, v_B, q'].
        out `y0` (6 + n): the same plus the pushes, which act at the base's origin and thus
            on v_B alone.

    Args:
        scenario: Its faults, which begin and end at reference times.
        joints: n.
    """
    pushes = [fault for fault in scenario.faults if isinstance(fault, Push)]
    if not pushes:
        return None
    time, force = Variable("t"), [Variable(f"f{i}") for i in range(6 + joints)]
    output = [Expression(f) for f in force]
    for push in pushes:
        for axis, newtons in enumerate(push.force_n):
            is_active = _is_active(push, scenario.settle_s, time)
            output[3 + axis] += if_then_else(is_active, newtons, 0.0)
    return _function(time, force, output)


def _degraded(
    scenario: Scenario, remaining: dict[int, tuple[int, float]], key: str, count: int
) -> SymbolicVectorSystem | None:
    """Makes a system that scales inputs; `remaining` is {index of the fault: (input, fraction)}."""
    if not remaining:
        return None
    time, inputs = Variable("t"), [Variable(f"u{i}") for i in range(count)]
    output = [Expression(u) for u in inputs]
    for i, (index, fraction) in remaining.items():
        if index >= count:
            raise ScenarioError(
                scenario.source,
                f"faults[{i}].{key}",
                f"expected a {key} of the robot in [0, {count - 1}], got {index}",
            )
        is_active = _is_active(scenario.faults[i], scenario.settle_s, time)
        output[index] *= if_then_else(is_active, fraction, 1.0)
    return _function(time, inputs, output)


def _is_active(fault: Fault, settle_s: float, time: Variable) -> object:
    start, end = (settle_s + t - ROUNDING_S for t in (fault.start_s, fault.end_s))
    return logical_and(time >= start, time < end)


def _function(
    time: Variable, inputs: Sequence[Variable], output: Sequence[Expression]
) -> SymbolicVectorSystem:
    """Makes a system without state from expressions of time and inputs."""
    return SymbolicVectorSystem(
        time=time,
        state=np.array([]),
        input=np.array(inputs),
        dynamics=np.array([]),
        output=np.array(output),
        time_period=0.0,
    )

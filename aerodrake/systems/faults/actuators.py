"""Faults between actuators and plant, and pushes, without Python in the loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.symbolic import Expression, Variable, if_then_else, logical_and
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.scenario import Fault, JointDegraded, Push, RotorDegraded, Scenario
from aerodrake.support.errors import ScenarioError

ROUNDING_S = 1e-9
"""By how much a plant's step may miss the instant at which a fault begins."""


def make_rotor_faults(scenario: Scenario, rotors: int) -> SymbolicVectorSystem | None:
    """What degraded rotors leave of the thrusts: None if no rotor ever is.

    Ports:
        in `u0` (k): thrusts, N, as lag and limits have them.
        out `y0` (k): N, each by the shares that all faults of its rotor leave of it.

    Args:
        scenario: Its faults; they begin and end at reference times.
        rotors: k.

    Raises:
        ScenarioError: if there is no such rotor.
    """
    shares = {
        i: (fault.rotor, fault.remaining)
        for i, fault in enumerate(scenario.faults)
        if isinstance(fault, RotorDegraded)
    }
    return _degraded(scenario, shares, "rotor", rotors)


def make_joint_faults(scenario: Scenario, joints: int) -> SymbolicVectorSystem | None:
    """What degraded motors leave of the joints' torques: None if no motor ever is.

    Ports:
        in `u0` (n): torques, N m, as commanded.
        out `y0` (n): N m, as they act.

    Args:
        scenario: Its faults; they begin and end at reference times.
        joints: n.

    Raises:
        ScenarioError: if there is no such joint.
    """
    shares = {
        i: (fault.joint, fault.remaining)
        for i, fault in enumerate(scenario.faults)
        if isinstance(fault, JointDegraded)
    }
    return _degraded(scenario, shares, "joint", joints)


def make_pushes(scenario: Scenario, joints: int) -> SymbolicVectorSystem | None:
    """Pushes on the base beside other forces: None if nobody ever pushes.

    Ports:
        in `u0` (6 + n): generalized force on the plant's velocities [omega_W, v_B, q'].
        out `y0` (6 + n): the same with the pushes, which move v_B alone since they are
            at the base's origin.

    Args:
        scenario: Its faults; they begin and end at reference times.
        joints: n.
    """
    pushes = [fault for fault in scenario.faults if isinstance(fault, Push)]
    if not pushes:
        return None
    time, force = Variable("t"), [Variable(f"f{i}") for i in range(6 + joints)]
    output = [Expression(f) for f in force]
    for push in pushes:
        for axis, newtons in enumerate(push.force_n):
            output[3 + axis] += if_then_else(_is_on(push, scenario.settle_s, time), newtons, 0.0)
    return _passing(time, force, output)


def _degraded(
    scenario: Scenario, shares: dict[int, tuple[int, float]], key: str, count: int
) -> SymbolicVectorSystem | None:
    """Inputs by the shares left of them, told as (which input, share) by the faults' places."""
    if not shares:
        return None
    time, given = Variable("t"), [Variable(f"u{i}") for i in range(count)]
    output = [Expression(u) for u in given]
    for i, (index, remaining) in shares.items():
        if index >= count:
            raise ScenarioError(
                scenario.source,
                f"faults[{i}].{key}",
                f"expected a {key} of the robot in [0, {count - 1}], got {index}",
            )
        output[index] *= if_then_else(
            _is_on(scenario.faults[i], scenario.settle_s, time), remaining, 1.0
        )
    return _passing(time, given, output)


def _is_on(fault: Fault, settle_s: float, time: Variable) -> object:
    start, end = (settle_s + t - ROUNDING_S for t in (fault.start_s, fault.end_s))
    return logical_and(time >= start, time < end)


def _passing(
    time: Variable, given: Sequence[Variable], output: Sequence[Expression]
) -> SymbolicVectorSystem:
    return SymbolicVectorSystem(
        time=time,
        state=np.array([]),
        input=np.array(given),
        dynamics=np.array([]),
        output=np.array(output),
        time_period=0.0,
    )

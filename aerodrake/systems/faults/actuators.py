"""Faults between actuators and plant, and pushes, as systems of Drake.

The functions for degraded actuators return None for a scenario without such faults. A fault is
active from `settle_s` plus its start until before its end.
"""

import numpy as np
from pydrake.symbolic import Expression, Formula, Variable, if_then_else, logical_and
from pydrake.systems.framework import System
from pydrake.systems.primitives import ConstantVectorSource, SymbolicVectorSystem

from aerodrake.scenario import Fault, JointDegraded, Push, RotorDegraded, Scenario
from aerodrake.support.arguments import Count, checked
from aerodrake.support.errors import ScenarioError

ROUNDING_S = 1e-9
"""Tolerance of the instants at which a fault begins and ends: times of plant steps are rounded."""


@checked
def make_rotor_faults(scenario: Scenario, rotors: Count) -> SymbolicVectorSystem | None:
    """Makes the system that reduces the thrusts of degraded rotors, with k = `rotors`.

    Ports:
        in `u0` (k): N, thrusts after lag and limits.
        out `y0` (k): N, thrusts times the remaining fractions of all active faults.

    Raises:
        ScenarioError: if a fault's rotor does not exist.
    """
    return _degraded(scenario, RotorDegraded, "rotor", rotors)


@checked
def make_joint_faults(scenario: Scenario, joints: Count) -> SymbolicVectorSystem | None:
    """Makes the system that reduces the torques of degraded motors, with n = `joints`.

    Ports:
        in `u0` (n): N m, commanded torques.
        out `y0` (n): N m, torques times the remaining fractions of all active faults.

    Raises:
        ScenarioError: if a fault's joint does not exist.
    """
    return _degraded(scenario, JointDegraded, "joint", joints)


@checked
def make_pushes(scenario: Scenario, joints: Count) -> System:
    """Makes the pushes on the base, with n = `joints`; zero for a scenario without them.

    Ports:
        out `y0` (6 + n): generalized force on the plant's velocities [omega_W, v_B, q']. Pushes
            act at the base's origin and thus on v_B alone.
    """
    pushes = [fault for fault in scenario.faults if isinstance(fault, Push)]
    if not pushes:
        return ConstantVectorSource(np.zeros(6 + joints))
    time, output = Variable("t"), [Expression(0.0) for _ in range(6 + joints)]
    for push in pushes:
        is_active = _is_active(push, scenario.settle_s, time)
        for axis, newtons in enumerate(push.force_n):
            output[3 + axis] += if_then_else(is_active, newtons, 0.0)
    return SymbolicVectorSystem(time, output=np.array(output))


def _degraded(
    scenario: Scenario, kind: type[Fault], key: str, count: int
) -> SymbolicVectorSystem | None:
    """Makes a system that scales each input whose index is the `key` of a fault of a kind."""
    faults = {i: fault for i, fault in enumerate(scenario.faults) if isinstance(fault, kind)}
    if not faults:
        return None
    time, inputs = Variable("t"), [Variable(f"u{i}") for i in range(count)]
    output = [Expression(u) for u in inputs]
    for i, fault in faults.items():
        index = getattr(fault, key)
        if index >= count:
            raise ScenarioError(
                scenario.source,
                f"faults[{i}].{key}",
                f"expected a {key} of the robot in [0, {count - 1}], got {index}",
            )
        is_active = _is_active(fault, scenario.settle_s, time)
        output[index] *= if_then_else(is_active, fault.remaining, 1.0)
    return SymbolicVectorSystem(time, input=np.array(inputs), output=np.array(output))


def _is_active(fault: Fault, settle_s: float, time: Variable) -> Formula:
    start, end = (settle_s + t - ROUNDING_S for t in (fault.start_s, fault.end_s))
    return logical_and(time >= start, time < end)

"""Commands that are at their limits where a loop is linearised."""

import numpy as np

from aerodrake.analysis.coordinates import StateCoordinates
from aerodrake.analysis.quiet_loop import QuietLoop

NEAR = 1e-6
"""Relative distance to a limit at which a command counts as at it."""


def saturated(quiet: QuietLoop) -> tuple[str, ...]:
    """Returns the names of the joints and rotors whose command is at its limit now.

    A small motion does not change such a command, so that its part of the loop is open.
    """
    vehicle, rotor, values = quiet.vehicle, quiet.scenario.vehicle.rotor, quiet.snapshot()
    groups = StateCoordinates.of(quiet.diagram, values, vehicle.joint_names).groups
    commands = {(group.system, group.name): values.value(group.index) for group in groups}
    names: list[str] = []
    for key, low, high, parts in (
        (
            ("arm_controller", "joint_torque"),
            -vehicle.effort,
            vehicle.effort,
            vehicle.joint_names,
        ),
        (
            ("flight_controller", "thrust_command"),
            rotor.min_thrust_n,
            rotor.max_thrust_n,
            vehicle.rotors.names,
        ),
    ):
        if key in commands:
            near = NEAR * np.abs(high)
            is_at = (commands[key] >= high - near) | (commands[key] <= low + near)
            names += [name for name, at in zip(parts, is_at, strict=True) if at]
    return tuple(names)

"""Commands that are at their limits where a loop is linearised."""

from aerodrake.analysis.quiet_loop import QuietLoop

NEAR = 1e-6
"""Distance to a limit, relative to the largest thrust, at which a rotor's command counts as at
it."""


def saturated(quiet: QuietLoop) -> tuple[str, ...]:
    """Returns the names of the joints and rotors whose command is at its limit now.

    A small motion does not change such a command, so that its part of the loop is open.
    """
    vehicle, rotor = quiet.vehicle, quiet.scenario.vehicle.rotor
    thrust, near = quiet.output("thrust_command"), NEAR * rotor.max_thrust_n
    low, high = rotor.min_thrust_n + near, rotor.max_thrust_n - near
    names = (*vehicle.joint_names, *vehicle.rotors.names)
    is_at = (*(quiet.output("torque_at_limit") > 0), *((thrust <= low) | (thrust >= high)))
    return tuple(name for name, at in zip(names, is_at, strict=True) if at)

"""Rotors and propellers at the plant's rate, as systems of Drake's own."""

from pydrake.math import RigidTransform
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.multibody.tree import BodyIndex
from pydrake.symbolic import Variable, exp, if_then_else, max, min
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.scenario import Mismatch, Rotor
from aerodrake.support.arguments import Period, Vector, checked
from aerodrake.support.errors import BadInput, show


@checked
def make_rotors(
    config: Rotor, mismatch: Mismatch, trim: Vector, period: Period
) -> SymbolicVectorSystem:
    """Makes the rotors: thrust limits and first-order lag of each, exactly discretised.

    Ports:
        in `u0` (k): commanded thrusts, N.
        out `y0` (k): thrusts, N.
    State:
        deviation of the thrusts from `trim` (k), so that the default Context, all
        zeros, is in trim.
    Rate:
        `period`.

    Args:
        config: Limits and time constants.
        mismatch: Factors on the time constants, and on the command's deviation
            from trim; the limits apply after the factor.
        trim: (k,) N, thrusts in trim.
        period: s, the plant's step.

    Raises:
        BadInput: if a thrust in trim is not within the limits.
    """
    low, high = config.min_thrust_n, config.max_thrust_n
    if not all(low - 1e-9 <= thrust <= high + 1e-9 for thrust in trim):
        expected = f"expected the thrust of each rotor in [{low:g}, {high:g}] N"
        raise BadInput("make_rotors", "trim", f"{expected}, got {show([*map(float, trim)])}")
    state = [Variable(f"df{i}") for i in range(len(trim))]
    command = [Variable(f"c{i}") for i in range(len(trim))]
    up, down = (
        1 - exp(-period / (mismatch.rotor_lag_scale * lag))
        for lag in (config.lag_up_s, config.lag_down_s)
    )
    dynamics = []
    for x, c, f0 in zip(state, command, trim, strict=True):
        scaled = c + (mismatch.thrust_scale - 1) * (c - f0)  # Exactly c if the scale is 1.
        gap = min(max(scaled, config.min_thrust_n), config.max_thrust_n) - (f0 + x)
        dynamics.append(x + if_then_else(gap > 0, up, down) * gap)
    output = [f0 + x for x, f0 in zip(state, trim, strict=True)]
    return SymbolicVectorSystem(
        state=state, input=command, dynamics=dynamics, output=output, time_period=period
    )


@checked
def make_propellers(rotor: Rotor, rotors: Rotors, base: BodyIndex) -> Propeller:
    """Makes the propellers, which apply thrusts (k) N and their drag torques to the base.

    Ports:
        in `command` (k): N, thrusts.
        in `body_poses` (abstract): pose of each body in the world, of the plant.
        out `spatial_forces` (abstract): force and torque of each rotor on the base, in the world.

    Args:
        rotor: Ratio of drag torque to thrust.
        rotors: Positions and directions of rotation.
        base: The body that they are attached to.
    """
    return Propeller(
        [
            PropellerInfo(base, RigidTransform(p), 1.0, -spin * rotor.torque_ratio_m)
            for p, spin in zip(rotors.p_B, rotors.spin, strict=True)
        ]
    )

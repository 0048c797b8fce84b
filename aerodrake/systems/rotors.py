"""Rotors and propellers at the plant's rate, without Python in the loop."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.multibody.tree import BodyIndex
from pydrake.symbolic import Variable, exp, if_then_else, max, min
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.scenario import Mismatch, Rotor


def make_rotors(
    config: Rotor, mismatch: Mismatch, trim: np.ndarray, period: float
) -> SymbolicVectorSystem:
    """Thrust limits and first-order lag of each rotor, exactly discretised.

    Ports:
        in `u0` (k): commanded thrusts, N.
        out `y0` (k): thrusts, N.
    State:
        deviation of the thrusts from `trim`, so that the default Context, all
        zeros, is in trim.
    Rate:
        `period`.

    Args:
        config: Limits and time constants.
        mismatch: Factors on the time constants, and on the command's deviation
            from trim; the limits are those of the thrust that comes of it.
        trim: (k,) N, thrusts in trim.
        period: s, the plant's step.
    """
    state = [Variable(f"df{i}") for i in range(len(trim))]
    command = [Variable(f"c{i}") for i in range(len(trim))]
    up, down = (
        1 - exp(-period / (mismatch.rotor_lag_scale * lag))
        for lag in (config.lag_up_s, config.lag_down_s)
    )
    dynamics = []
    for x, c, f0 in zip(state, command, trim, strict=True):
        wanted = c + (mismatch.thrust_scale - 1) * (c - f0)  # Just c where the scale is 1.
        gap = min(max(wanted, config.min_thrust_n), config.max_thrust_n) - (f0 + x)
        dynamics.append(x + if_then_else(gap > 0, up, down) * gap)
    output = [f0 + x for x, f0 in zip(state, trim, strict=True)]
    return SymbolicVectorSystem(
        state=state, input=command, dynamics=dynamics, output=output, time_period=period
    )


def make_propellers(rotor: Rotor, rotors: Rotors, base: BodyIndex) -> Propeller:
    """The wrenches that thrusts (k) N exert on the base, with their drag torque.

    Args:
        rotor: Ratio of drag torque to thrust.
        rotors: Where they are, and which way they turn.
        base: The body they are on.
    """
    return Propeller(
        [
            PropellerInfo(base, RigidTransform(p), 1.0, -spin * rotor.torque_ratio_m)
            for p, spin in zip(rotors.p_B, rotors.spin, strict=True)
        ]
    )

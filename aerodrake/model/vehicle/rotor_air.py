"""Effects of the air on the rotors: drag, inflow, ground and ceiling."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Air
from aerodrake.support.compiled import compiled

NEAREST = 0.5
"""Least distance from ground and ceiling, in radii, for which the thrust ratios are valid."""


class RotorAir(NamedTuple):
    """Effects of the air on k rotors.

    Attributes:
        p_B: (k, 3) m, hubs in the base frame.
        drag: N s/m, of one rotor.
        inflow: s/m.
        radius: m, of a rotor; 0 for no effect of ground and ceiling.
        ceiling: m, height of the ceiling; infinite without one.
    """

    p_B: np.ndarray
    drag: float
    inflow: float
    radius: float
    ceiling: float

    @classmethod
    def make(cls, config: Air, rotors: Rotors) -> Self:
        """Returns the effects of a scenario on a vehicle's rotors."""
        return cls(
            p_B=np.ascontiguousarray(rotors.p_B),
            drag=config.rotor_drag_n_s_m / len(rotors.p_B),
            inflow=config.inflow_s_m,
            radius=config.rotor_radius_m,
            ceiling=config.ceiling_m or np.inf,
        )


class RotorForces(NamedTuple):
    """Thrusts of the rotors in the air, and their drag.

    Attributes:
        thrust: (k,) N.
        drag: (6,) N m about the base's origin, then N, in the world.
    """

    thrust: np.ndarray
    drag: np.ndarray


@compiled
def ground_ratio(radius: float, height: float) -> float:
    """Returns the thrust at a height above the ground over that far from it, at constant power.

    T / T_inf = 1 / (1 - (R / 4 z)^2) (Cheeseman and Bennett 1955, "The effect of the ground on a
    helicopter rotor in forward flight"), constant below `NEAREST` radii.

    Args:
        radius: m, R.
        height: m, z, of the hub above the ground.
    """
    ratio = radius / (4 * max(height, NEAREST * radius))
    return 1 / (1 - ratio**2)


@compiled
def ceiling_ratio(radius: float, distance: float) -> float:
    """Returns the thrust at a distance below a ceiling over that far from it, at constant power.

    T / T_inf = gamma^(2/3), gamma = (1 + sqrt(1 + (R / d)^2 / 8)) / 2 (Hsiao and Chirarattananon
    2019, "Ceiling effects for hybrid aerial-surface locomotion of small rotorcraft"), constant
    nearer than `NEAREST` radii.

    Args:
        radius: m, R.
        distance: m, d, of the hub from the ceiling.
    """
    ratio = radius / max(distance, NEAREST * radius)
    return ((1 + np.sqrt(1 + ratio**2 / 8)) / 2) ** (2 / 3)


@compiled
def inflow_ratio(inflow: float, climb: float) -> float:
    """Returns the thrust of a rotor that climbs in the air over that in hover.

    1 - inflow V, for an axial velocity V in m/s against the air, at least 0 and at most 2. For
    constant power, momentum theory gives T (V / 2 + sqrt(V^2 / 4 + v_h^2)) = T_h v_h and hence
    inflow = 1 / (2 v_h), with the induced velocity in hover v_h = sqrt(T_h / (2 rho A)) (Leishman,
    "Principles of Helicopter Aerodynamics", axial climb).
    """
    return min(max(1 - inflow * climb, 0.0), 2.0)


@compiled
def rotor_forces(
    air: RotorAir, thrust: np.ndarray, wind: np.ndarray, state: np.ndarray
) -> RotorForces:
    """Returns thrusts and drag of the rotors.

    The drag of a rotor is proportional to the velocity of its hub against the air in the plane of
    the rotor (Faessler et al. 2018, "Differential flatness of quadrotor dynamics subject to rotor
    drag"), and acts at the hub.

    Args:
        air: The effects.
        thrust: (k,) N, without them.
        wind: (3,) m/s, velocity of the air in the world.
        state: (13 + 2 n,) of the vehicle.
    """
    x = split_state(state)
    R = rotation_matrix(x.quaternion)
    axis = R[:, 2].copy()
    changed, drag = np.empty(len(thrust)), np.zeros(6)
    for i in range(len(thrust)):
        arm = R @ air.p_B[i]
        velocity = x.v_B + np.cross(x.omega_W, arm) - wind
        climb = velocity @ axis
        ratio = inflow_ratio(air.inflow, climb)
        if air.radius > 0.0:
            height = x.p_B[2] + arm[2]
            ratio *= ground_ratio(air.radius, height)
            ratio *= ceiling_ratio(air.radius, air.ceiling - height)
        changed[i] = ratio * thrust[i]
        force = -air.drag * (velocity - climb * axis)
        drag[:3] += np.cross(arm, force)
        drag[3:] += force
    return RotorForces(changed, drag)

"""The outer loop of the flight controller: from a base setpoint to the acceleration wanted."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.low_level.eso import ExtendedStateObserver, observe
from aerodrake.model.low_level.flight_law import PositionGains, desired_thrust, position_law
from aerodrake.model.low_level.flight_memory import memory_parts
from aerodrake.model.vehicle.rotation import UP
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Flight, Rotor
from aerodrake.support.compiled import compiled


class OuterLoop(NamedTuple):
    """Its constants.

    Attributes:
        gains: Of the position law.
        eso: The position observer.
        is_trajectory: Whether v_d and a_d are heeded, not p_d alone.
        max_tilt: rad.
        most_thrust: m/s^2, of all rotors over mass.
        dt: s, period.
    """

    gains: PositionGains
    eso: ExtendedStateObserver
    is_trajectory: bool
    max_tilt: float
    most_thrust: float
    dt: float

    @classmethod
    def make(cls, config: Flight, rotor: Rotor, vehicle: VehicleModel, period: float) -> OuterLoop:
        """Of the scenario's gains and this vehicle; `period` in s."""
        return cls(
            gains=PositionGains.make(config),
            eso=ExtendedStateObserver.make(2, config.position_eso_rad_s, period),
            is_trajectory=config.interface == "trajectory",
            max_tilt=config.max_tilt_rad,
            most_thrust=len(vehicle.rotors.names) * rotor.max_thrust_n / vehicle.mass,
            dt=period,
        )


@compiled
def outer_loop(
    loop: OuterLoop, x: np.ndarray, believed: np.ndarray, state: np.ndarray, setpoint: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position observer and position law.

    Args:
        loop: Its constants.
        x: (30 + k,) memory.
        believed: (6,) acceleration since the last sample, without disturbances, linear
            and angular; m/s^2 in the world and rad/s^2 in the base frame.
        state: (13 + 2 n,) measured.
        setpoint: (9,) p_d, v_d, a_d in m, m/s, m/s^2.

    Returns:
        (12,) position observer now, and integral if nothing saturates; u_v (3,)
        m/s^2, wanted; a_B (3,) m/s^2, as much of it as tilt and thrust allow.
    """
    observer, _, integral, _, _, _ = memory_parts(x)
    _, p_B, _, _, v_B, _ = split_state(state)
    p_d, v_d, a_d = setpoint[:3], setpoint[3:6], setpoint[6:]
    if not loop.is_trajectory:
        v_d = a_d = np.zeros(3)
    observer = observe(loop.eso, observer, believed[:3], p_B)
    error = p_B - p_d
    u_v = position_law(loop.gains, error, v_B - v_d, a_d, observer[-1], integral)
    thrust = desired_thrust(u_v, loop.max_tilt)
    share = min(1.0, loop.most_thrust / np.sqrt(np.sum(thrust * thrust)))
    position = np.concatenate((observer.ravel(), integral + loop.dt * error))
    return position, u_v, share * thrust - GRAVITY * UP

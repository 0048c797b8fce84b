"""Outer loop of the flight controller: from a base setpoint to a desired acceleration."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.low_level.eso import ExtendedStateObserver, observe
from aerodrake.model.low_level.flight_law import FlightGains, desired_thrust, position_law
from aerodrake.model.low_level.flight_state import FlightState
from aerodrake.model.vehicle.rotation import UP
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Flight, Rotor
from aerodrake.support.compiled import compiled


class OuterLoop(NamedTuple):
    """Constants of the outer loop.

    Attributes:
        gains: Gains of the flight laws.
        eso: Position observer.
        is_trajectory: True if v_d and a_d are used, not p_d alone.
        max_tilt: rad.
        max_specific_thrust: m/s^2, of all rotors together.
        dt: s, period.
    """

    gains: FlightGains
    eso: ExtendedStateObserver
    is_trajectory: bool
    max_tilt: float
    max_specific_thrust: float
    dt: float

    @classmethod
    def make(cls, config: Flight, rotor: Rotor, vehicle: VehicleModel, period: float) -> Self:
        """Returns the loop for a scenario's gains and a vehicle; `period` in s."""
        return cls(
            gains=FlightGains.make(config),
            eso=ExtendedStateObserver.make(2, config.position_eso_rad_s, period),
            is_trajectory=config.interface == "trajectory",
            max_tilt=config.max_tilt_rad,
            max_specific_thrust=len(vehicle.rotors.names) * rotor.max_thrust_n / vehicle.mass,
            dt=period,
        )


class PositionCommand(NamedTuple):
    """Result of the outer loop.

    Attributes:
        observer: (3, 3) position observer at this sample.
        integral: (3,) m s, new integral of the position error, unless the inner loop saturates.
        u_v: (3,) m/s^2, desired acceleration.
        a_B: (3,) m/s^2, u_v within the limits of tilt and thrust.
    """

    observer: np.ndarray
    integral: np.ndarray
    u_v: np.ndarray
    a_B: np.ndarray


@compiled
def outer_loop(
    loop: OuterLoop, last: FlightState, state: np.ndarray, setpoint: np.ndarray
) -> PositionCommand:
    """Runs position observer and position law.

    Args:
        loop: Constants.
        last: State of the flight controller.
        state: (13 + 2 n,) measured.
        setpoint: (9,) p_d, v_d, a_d in m, m/s, m/s^2.
    """
    _, p_B, _, _, v_B, _ = split_state(state)
    p_d, v_d, a_d = setpoint[:3], setpoint[3:6], setpoint[6:]
    if not loop.is_trajectory:
        v_d = a_d = np.zeros(3)
    observer = observe(loop.eso, last.position_observer, last.acceleration[:3], p_B)
    error, integral = p_B - p_d, last.position_integral
    u_v = position_law(loop.gains, error, v_B - v_d, a_d, observer[-1], integral)
    thrust = desired_thrust(u_v, loop.max_tilt)
    scale = min(1.0, loop.max_specific_thrust / np.sqrt(np.sum(thrust * thrust)))
    return PositionCommand(observer, integral + loop.dt * error, u_v, scale * thrust - GRAVITY * UP)

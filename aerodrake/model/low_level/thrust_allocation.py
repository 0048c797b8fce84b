"""From a desired wrench to rotor thrusts within their limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Rotor, Scenario
from aerodrake.support.compiled import compiled
from aerodrake.support.errors import ScenarioError


class ThrustAllocation(NamedTuple):
    """The rotors as a wrench is shared among them.

    Attributes:
        mixer: (4, k), from thrusts to [collective thrust, torque x, y, z].
        inverse: (4, k), for each component of the wrench, the thrusts that give one of it
            and nothing else.
        minimum: N, smallest thrust of a rotor.
        maximum: N, largest thrust of a rotor.
    """

    mixer: np.ndarray
    inverse: np.ndarray
    minimum: float
    maximum: float

    @classmethod
    def of(cls, mixer: np.ndarray, minimum: float, maximum: float) -> ThrustAllocation:
        """For a mixer (4, k), and minimum and maximum in N."""
        return cls(mixer, np.ascontiguousarray(np.linalg.pinv(mixer).T), minimum, maximum)

    @classmethod
    def make(cls, vehicle: VehicleModel, rotor: Rotor) -> ThrustAllocation:
        """For the rotors of `vehicle`.

        Raises:
            ScenarioError: if they cannot lift it without tilting it.
        """
        mixer = vehicle.rotors.mixer(rotor.torque_ratio_m)
        allocation = cls.of(mixer, rotor.min_thrust_n, rotor.max_thrust_n)
        if not (allocation.inverse[0] > 1e-6).all():
            raise ScenarioError(
                vehicle.source,
                "vehicle.robot",
                f"{vehicle.robot}: expected rotors all around the base's origin",
            )
        return allocation


def thrust_notes(scenario: Scenario) -> list[str]:
    """What should be known of rotors that do not hold the vehicle up within their limits."""
    rotor, vehicle = scenario.vehicle.rotor, VehicleModel.load(scenario)
    trim = vehicle.trim_wrench @ ThrustAllocation.make(vehicle, rotor).inverse
    found = []
    if trim.max() >= rotor.max_thrust_n:
        found.append(
            f"vehicle.rotor.max_thrust_n ({rotor.max_thrust_n:g} N) is no more than a rotor is to "
            f"give in hover ({trim.max():.4g} N): it falls"
        )
    if trim.min() <= rotor.min_thrust_n:
        found.append(
            f"vehicle.rotor.min_thrust_n ({rotor.min_thrust_n:g} N) is no less than a rotor is to "
            f"give in hover ({trim.min():.4g} N): it cannot stay"
        )
    return found


@compiled
def allocate(rotors: ThrustAllocation, wrench: np.ndarray) -> np.ndarray:
    """(k,) N, rotor thrusts for wrench (4,) [N, N m, N m, N m].

    Where thrust runs out, tilt and thrust go before yaw. Roll and pitch torque
    keep the vehicle upright, so they are served first; collective thrust gets
    what they leave, and yaw what is left after both.
    """
    minimum, maximum, per_lift = rotors.minimum, rotors.maximum, rotors.inverse[0]
    tilt = rotors.inverse[1] * wrench[1] + rotors.inverse[2] * wrench[2]
    yaw = rotors.inverse[3] * wrench[3]
    spread = tilt.max() - tilt.min()
    if spread > maximum - minimum:
        tilt *= (maximum - minimum) / spread
    least = ((minimum - tilt) / per_lift).max()
    most = ((maximum - tilt) / per_lift).min()
    thrust = per_lift * min(max(wrench[0], least), most) + tilt
    share = 1.0
    for i in range(len(yaw)):
        room = maximum - thrust[i] if yaw[i] > 0 else thrust[i] - minimum
        if abs(yaw[i]) > room:
            share = min(share, max(room, 0.0) / abs(yaw[i]))
    return np.minimum(np.maximum(thrust + share * yaw, minimum), maximum)

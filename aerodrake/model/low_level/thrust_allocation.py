"""Allocation of a desired wrench to rotor thrusts within their limits."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Rotor, Scenario
from aerodrake.support.compiled import compiled
from aerodrake.support.errors import ScenarioError


class ThrustAllocation(NamedTuple):
    """Mixer, its pseudo-inverse, and limits of the rotors.

    Attributes:
        mixer: (4, k), from thrusts to [collective thrust, torque x, y, z].
        inverse: (4, k), transposed pseudo-inverse of the mixer: row i has the thrusts that
            make one unit of component i, and nothing else.
        minimum: N, smallest thrust of a rotor.
        maximum: N, largest thrust of a rotor.
    """

    mixer: np.ndarray
    inverse: np.ndarray
    minimum: float
    maximum: float

    @classmethod
    def of(cls, mixer: np.ndarray, minimum: float, maximum: float) -> Self:
        """Returns the allocation for a mixer (4, k); minimum and maximum in N."""
        return cls(mixer, np.ascontiguousarray(np.linalg.pinv(mixer).T), minimum, maximum)

    @classmethod
    def make(cls, vehicle: VehicleModel, rotor: Rotor) -> Self:
        """Returns the allocation for the rotors of a vehicle.

        Raises:
            ScenarioError: if they cannot lift the vehicle without tilting it.
        """
        mixer = vehicle.rotors.mixer(rotor.torque_ratio_m)
        allocation = cls.of(mixer, rotor.min_thrust_n, rotor.max_thrust_n)
        names = zip(vehicle.rotors.names, allocation.inverse[0], strict=True)
        if idle := [name for name, thrust in names if thrust <= 1e-6]:
            # With positions alone, without the drag torques.
            is_around = (np.linalg.pinv(mixer[:3])[:, 0] > 1e-6).all()
            expected, torque = (
                ("directions of rotation, _ccw and _cw, that balance in hover", "yaw torque")
                if is_around
                else ("rotors all around the base's origin", "torque")
            )
            raise ScenarioError(
                vehicle.source,
                "vehicle.robot",
                f"{vehicle.robot}: expected {expected}; for lift without {torque}, "
                f"{', '.join(idle)} would have to pull down",
            )
        return allocation


def trim_thrust(vehicle: VehicleModel, rotor: Rotor) -> np.ndarray:
    """Returns the thrusts (k,) N in trim, within the rotors' limits.

    Raises:
        ScenarioError: as `ThrustAllocation.make`.
    """
    return allocate(ThrustAllocation.make(vehicle, rotor), vehicle.trim_wrench)


def thrust_notes(scenario: Scenario, vehicle: VehicleModel) -> list[str]:
    """Returns a note for each thrust limit of the rotors that prevents hovering."""
    rotor = scenario.vehicle.rotor
    trim = vehicle.trim_wrench @ ThrustAllocation.make(vehicle, rotor).inverse
    notes = []
    if trim.max() >= rotor.max_thrust_n:
        notes.append(
            f"vehicle.rotor.max_thrust_n ({rotor.max_thrust_n:g} N) is not above the largest "
            f"thrust of a rotor in hover ({trim.max():.4g} N): the vehicle falls"
        )
    if trim.min() <= rotor.min_thrust_n:
        notes.append(
            f"vehicle.rotor.min_thrust_n ({rotor.min_thrust_n:g} N) is not below the smallest "
            f"thrust of a rotor in hover ({trim.min():.4g} N): the vehicle cannot hover"
        )
    return notes


@compiled
def allocate(rotors: ThrustAllocation, wrench: np.ndarray) -> np.ndarray:
    """Returns the rotor thrusts (k,) N for a wrench (4,) [N, N m, N m, N m].

    At the thrust limits, roll and pitch torque have priority, since they keep the vehicle
    upright. Collective thrust comes second, and yaw torque last.
    """
    minimum, maximum, per_lift = rotors.minimum, rotors.maximum, rotors.inverse[0]
    tilt = rotors.inverse[1] * wrench[1] + rotors.inverse[2] * wrench[2]
    yaw = rotors.inverse[3] * wrench[3]
    spread = tilt.max() - tilt.min()
    if spread > maximum - minimum:
        tilt *= (maximum - minimum) / spread
    lowest = ((minimum - tilt) / per_lift).max()
    highest = ((maximum - tilt) / per_lift).min()
    thrust = per_lift * min(max(wrench[0], lowest), highest) + tilt
    scale = 1.0
    for i in range(len(yaw)):
        margin = maximum - thrust[i] if yaw[i] > 0 else thrust[i] - minimum
        if abs(yaw[i]) > margin:
            scale = min(scale, max(margin, 0.0) / abs(yaw[i]))
    return np.minimum(np.maximum(thrust + scale * yaw, minimum), maximum)

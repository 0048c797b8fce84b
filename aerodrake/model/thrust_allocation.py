"""From a desired wrench to rotor thrusts within their limits."""

from __future__ import annotations

import numpy as np

from aerodrake.errors import BadInput
from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Rotor


class ThrustAllocation:
    """Inverts the mixer; where thrust runs out, tilt and thrust go before yaw.

    Roll and pitch torque keep the vehicle upright, so they are served first;
    collective thrust gets what they leave, and yaw what is left after both.

    Args:
        mixer: (4, k), from thrusts to [collective thrust, torque x, y, z].
        minimum: N, smallest thrust of a rotor.
        maximum: N, largest thrust of a rotor.
    """

    def __init__(self, mixer: np.ndarray, minimum: float, maximum: float):
        self.mixer = mixer
        self._inverse = np.linalg.pinv(mixer)
        self._minimum, self._maximum = minimum, maximum

    @classmethod
    def make(cls, vehicle: Vehicle, rotor: Rotor) -> ThrustAllocation:
        """For the rotors of `vehicle`.

        Raises:
            BadInput: if they cannot lift it without tilting it.
        """
        mixer = vehicle.rotors.mixer(rotor.torque_ratio_m)
        allocation = cls(mixer, rotor.min_thrust_n, rotor.max_thrust_n)
        if not (allocation._inverse[:, 0] > 1e-6).all():
            raise BadInput(vehicle.robot, "", "expected rotors all around the base's origin")
        return allocation

    def allocate(self, wrench: np.ndarray) -> np.ndarray:
        """(k,) N, rotor thrusts for wrench (4,) [N, N m, N m, N m]."""
        lift = self._inverse[:, 0]
        tilt = self._inverse[:, 1:3] @ wrench[1:3]
        yaw = self._inverse[:, 3] * wrench[3]
        spread = tilt.max() - tilt.min()
        if spread > self._maximum - self._minimum:
            tilt *= (self._maximum - self._minimum) / spread
        least = ((self._minimum - tilt) / lift).max()
        most = ((self._maximum - tilt) / lift).min()
        thrust = lift * min(max(wrench[0], least), most) + tilt
        room = np.where(yaw > 0, self._maximum - thrust, thrust - self._minimum)
        share = np.divide(room, np.abs(yaw), out=np.ones_like(yaw), where=yaw != 0)
        yaw *= np.clip(share.min(), 0.0, 1.0)
        return np.clip(thrust + yaw, self._minimum, self._maximum)

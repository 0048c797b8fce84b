"""Constant errors of the measured state: biases, and zeros of the joints."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.joint_values import per_joint
from aerodrake.model.vehicle.rotation import apply, rotation_matrix, turned
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Sensors
from aerodrake.support.compiled import compiled


class SensorErrors(NamedTuple):
    """Biases of the sensors.

    Attributes:
        position: (3,) m, in the world.
        attitude: (3,) rad, rotation vector from the true to the measured base frame.
        zero: (n,) rad, measured minus true angles of the joints.
    """

    position: np.ndarray
    attitude: np.ndarray
    zero: np.ndarray

    @classmethod
    def make(cls, config: Sensors, joints: int) -> Self:
        """Returns the errors of a scenario's sensors for n = `joints`.

        Raises:
            ScenarioError: if the number of zeros is neither 1 nor n.
        """
        zeros = per_joint(config.joints.zero_rad, joints, "", "sensors.joints.zero_rad")
        position, attitude = np.array(config.position.bias_m), np.array(config.attitude.bias_rad)
        return cls(position, attitude, zeros.copy())


@compiled
def biased(errors: SensorErrors, rate_bias: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Returns a state x (13 + 2 n,) as sensors without noise measure it.

    `rate_bias` (3,) rad/s is that of the gyroscope, in the base frame.
    """
    measured = x.copy()
    quaternion, p_B, q, omega_W, _, _ = split_state(measured)
    omega_W += apply(rotation_matrix(quaternion), rate_bias)
    p_B += errors.position
    q += errors.zero
    if np.any(errors.attitude != 0.0):
        quaternion[:] = turned(quaternion, errors.attitude)
    return measured

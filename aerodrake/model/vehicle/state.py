"""State vector of the vehicle and its named parts."""

from typing import NamedTuple, Self

import numpy as np
from pydrake.math import RollPitchYaw

from aerodrake.model.vehicle.rotation import roll_pitch_yaw, rotation_matrix, rpy_rates
from aerodrake.support.compiled import compiled

BASE_POSITIONS = 7
"""Size of the base's part of q: its quaternion and p_B."""
BASE_VELOCITIES = 6
"""Size of the base's part of v: omega_W and v_B."""


class VehicleState(NamedTuple):
    """State of the vehicle, in the order of `MultibodyPlant`.

    `split_state` gives the parts of a state vector their names, `to_vector` is its inverse, and
    `_replace` changes parts by name:

        state = split_state(closed_loop.GetOutputPort("true_state").Eval(context))
        raised = state._replace(p_B=state.p_B + [0.0, 0.0, 0.1])
        plant.SetPositionsAndVelocities(plant_context, raised.to_vector())

    Attributes:
        quaternion: (4,) attitude of the base, w first.
        p_B: (3,) m, base origin in the world.
        q: (n,) rad, joint angles.
        omega_W: (3,) rad/s, angular velocity of the base, expressed in the world.
        v_B: (3,) m/s, velocity of the base origin in the world.
        qdot: (n,) rad/s, joint velocities.
    """

    quaternion: np.ndarray
    p_B: np.ndarray
    q: np.ndarray
    omega_W: np.ndarray
    v_B: np.ndarray
    qdot: np.ndarray

    @staticmethod
    def size(joints: int) -> int:
        """Returns the length of the state vector for an arm of `joints` joints."""
        return BASE_POSITIONS + BASE_VELOCITIES + 2 * joints

    @classmethod
    def at_rest(cls, p_B: np.ndarray, q: np.ndarray, rpy: tuple[float, ...] = (0, 0, 0)) -> Self:
        """Returns a state without motion.

        Args:
            p_B: (3,) m, base origin in the world.
            q: (n,) rad, joint angles.
            rpy: Roll, pitch and yaw of the base in rad.
        """
        quaternion = RollPitchYaw(rpy).ToQuaternion().wxyz()
        still = np.zeros(3)
        return cls(quaternion, np.array(p_B), np.array(q), still, still, np.zeros(len(q)))

    def to_vector(self) -> np.ndarray:
        """Returns the state vector (13 + 2 n,), the inverse of `split_state`."""
        return np.concatenate(
            [self.quaternion, self.p_B, self.q, self.omega_W, self.v_B, self.qdot]
        )

    @property
    def R_B(self) -> np.ndarray:
        """(3, 3) rotation from the base to the world frame."""
        return rotation_matrix(self.quaternion)

    @property
    def rpy(self) -> np.ndarray:
        """(3,) rad, roll, pitch and yaw: the paper's Theta_B."""
        return roll_pitch_yaw(self.R_B)

    @property
    def rpy_rates(self) -> np.ndarray:
        """(3,) rad/s, time derivative of Theta_B."""
        return rpy_rates(self.R_B, self.omega_W)


@compiled
def split_state(x: np.ndarray) -> VehicleState:
    """Returns the parts of a state vector x (13 + 2 n,) as views, not copies.

    The joints are counted from the length. For states over time, x is (13 + 2 n, T) as
    `VectorLog.data` has them, and the parts are (4, T), (3, T), (n, T): the base's path is
    `split_state(log.data()).p_B`.
    """
    n = (len(x) - BASE_POSITIONS - BASE_VELOCITIES) // 2
    v = BASE_POSITIONS + n
    return VehicleState(x[:4], x[4:7], x[7:v], x[v : v + 3], x[v + 3 : v + 6], x[v + 6 :])

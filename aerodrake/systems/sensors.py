"""Samples of the vehicle's state, shared by everything that looks at it."""

from __future__ import annotations

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.systems.framework import Context, LeafSystem, State

from aerodrake.model.vehicle_state import VehicleState
from aerodrake.scenario import Sensors


def noise_size(joints: int) -> int:
    """How many independent draws one sample takes: base 12, and one per joint."""
    return 12 + joints


def disturbed(config: Sensors, x: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """The state vector x with measurement noise on it.

    Args:
        config: Standard deviations.
        x: (13 + 2 n,) the true state, as `VehicleState` has it.
        noise: (12 + n,) standard normal draws: position, velocity, attitude,
            rates (3 each), joint angles.
    """
    true = VehicleState.from_vector(x)
    position, velocity, attitude, rates, joints = np.split(noise, [3, 6, 9, 12])
    turn = RollPitchYaw(config.attitude_noise_rad * attitude).ToRotationMatrix()
    R = RotationMatrix(Quaternion(true.quaternion / np.linalg.norm(true.quaternion)))
    return VehicleState(
        quaternion=R.multiply(turn).ToQuaternion().wxyz(),
        p_B=true.p_B + config.position_noise_m * position,
        q=true.q + config.joint_noise_rad * joints,
        omega_W=true.omega_W + config.rate_noise_rad_s * rates,
        v_B=true.v_B + config.velocity_noise_m_s * velocity,
        qdot=true.qdot,
    ).to_vector()


class SensorSystem(LeafSystem):
    """Samples the state and holds it: exact by default, noisy if the scenario says so.

    Ports:
        in `true_state` (13 + 2 n): the plant's state.
        in `noise` (12 + n): standard normal draws, new at each sample.
        out `state` (13 + 2 n): the last sample.
    State:
        the last sample.
    Rate:
        `period`, by an *unrestricted* update: these run before the discrete
        updates of the same instant, so that a controller that ticks together
        with the sensors sees the new sample and not one that is a period old.

    Args:
        config: Standard deviations of the noise.
        joints: n.
        period: s.
        initial: (13 + 2 n,) the sample before the first.
    """

    def __init__(self, config: Sensors, joints: int, period: float, initial: np.ndarray):
        super().__init__()
        self._config = config
        self._is_exact = config == Sensors()
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(joints))
        self._noise = self.DeclareVectorInputPort("noise", noise_size(joints))
        self._sample_index = self.DeclareDiscreteState(initial)
        self.DeclareStateOutputPort("state", self._sample_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context: Context, state: State) -> None:
        x = self._true_state.Eval(context)
        if not self._is_exact:
            x = disturbed(self._config, x, self._noise.Eval(context))
        state.get_mutable_discrete_state(self._sample_index).SetFromVector(x)

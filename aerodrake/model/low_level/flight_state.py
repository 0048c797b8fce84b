"""State and outputs of the flight controller."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.state import VehicleState

JUMP_M = 0.05
"""Step of the measured position, beyond its velocity, that no vehicle makes from one sample to the
next."""


class FlightState(NamedTuple):
    """State of the flight controller's loops at a sample.

    Attributes:
        position_observer: (3, 3) rows p_hat (m), v_hat (m/s), h (m/s^2).
        attitude_observer: (2, 3) rows omega_hat (rad/s), h_omega (rad/s^2).
        position_integral: (3,) m s, of the position error.
        R_d: (3, 3) desired attitude.
        omega_d: (3,) rad/s, filtered rate of R_d in its own frame.
        rotor_thrust: (k,) N, modelled at the next sample.
        specific_thrust: m/s^2, collective thrust over mass at the next sample, modelled by
            rotors with one lag, the mean of rise and fall.
        acceleration: (6,) of the base until the next sample, modelled without disturbances:
            m/s^2 in the world and rad/s^2 in the base frame.
        joint_acceleration: (n,) rad/s^2, filtered q_d'' of the feedforward `torque`.
        p_B: (3,) m, measured; NaN before the first sample.
    """

    position_observer: np.ndarray
    attitude_observer: np.ndarray
    position_integral: np.ndarray
    R_d: np.ndarray
    omega_d: np.ndarray
    rotor_thrust: np.ndarray
    specific_thrust: float
    acceleration: np.ndarray
    joint_acceleration: np.ndarray
    p_B: np.ndarray

    @classmethod
    def at_rest(
        cls, p_B: np.ndarray, h_omega: np.ndarray, thrust: np.ndarray, mass: float, joints: int
    ) -> Self:
        """Returns the state in which the base is at rest, and level, at p_B.

        Args:
            p_B: (3,) m.
            h_omega: (3,) rad/s^2, disturbance that the modelled acceleration compensates.
            thrust: (k,) N, of the rotors.
            mass: kg.
            joints: Number of joints.
        """
        zero = np.zeros(3)
        return cls(
            position_observer=np.stack([p_B, zero, zero]),
            attitude_observer=np.stack([zero, h_omega]),
            position_integral=zero,
            R_d=np.eye(3),
            omega_d=zero,
            rotor_thrust=thrust,
            specific_thrust=thrust.sum() / mass,
            acceleration=np.concatenate([zero, -h_omega]),
            joint_acceleration=np.zeros(joints),
            p_B=np.full(3, np.nan),
        )

    def aligned(self, state: VehicleState, dt: float) -> Self:
        """Returns the state with its observers at the first sample, or moved by a jump.

        The measured position jumps if its estimator is reset, which is no disturbance.

        Args:
            state: Measured now.
            dt: s, from the sample before.
        """
        observer = self.position_observer.copy()
        if np.isfinite(self.p_B[0]):
            step = state.p_B - self.p_B - dt * state.v_B
            if step @ step > JUMP_M**2:
                observer[0] += step
            return self._replace(position_observer=observer, p_B=state.p_B)
        observer[0], observer[1] = state.p_B - dt * state.v_B, state.v_B
        attitude_observer = self.attitude_observer.copy()
        attitude_observer[0] = state.R_B.T @ state.omega_W
        return self._replace(
            position_observer=observer, attitude_observer=attitude_observer, p_B=state.p_B
        )


class FlightOutputs(NamedTuple):
    """Outputs of the flight controller, as in its ports, beside those of `FlightState`.

    Attributes:
        thrust_command: (k,) N.
        reaction: (3,) m/s^2.
        disturbance: (6,) m/s^2 and rad/s^2.
        saturated: True if the command is less than the control laws demand.
    """

    thrust_command: np.ndarray
    reaction: np.ndarray
    disturbance: np.ndarray
    saturated: bool

"""The state of the vehicle now, from noisy samples that come late."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from scipy.linalg import solve_discrete_are

from aerodrake.model.vehicle_state import VehicleState
from aerodrake.scenario import Filter

JOINT_WALK_RAD = 1e-4
"""Standard deviation, per sample, of what the measured joint rates miss of the joints' motion."""


@dataclass(frozen=True)
class Estimate:
    """Where the vehicle is believed to be.

    Attributes:
        state: As measured it would be.
        d: (3,) m/s^2, acceleration of the base beyond the modelled one, in the world.
        delta: (3,) rad/s^2, the same of its rotation, in the base frame.
    """

    state: VehicleState
    d: np.ndarray
    delta: np.ndarray

    def to_vector(self) -> np.ndarray:
        """(19 + 2 n,) [d, delta, state]."""
        return np.concatenate([self.d, self.delta, self.state.to_vector()])

    @classmethod
    def from_vector(cls, x: np.ndarray) -> Estimate:
        """The reverse of `to_vector`."""
        return cls(VehicleState.from_vector(x[6:]), x[:3], x[3:6])


class StateFilter:
    """Steady-state Kalman filters of the base's motion, of its rotation, and of the joints.

    Motion along each axis is the chain p' = v, v' = a + d, d' = noise, of which
    p and v are measured, and a is what the flight controller believes of its
    command. Rotation about each axis is the same chain, with attitude errors as
    rotation vectors in the base frame. Each joint is q' = q_m' + noise. Gains
    follow from the scenario's noise by the Riccati equation once and for all.

    Base samples that are late are met with the estimate of their own time, from
    which the modelled accelerations since then lead to the present.

    Args:
        config: Noise of samples and disturbances, and lateness.
        dt: s, between samples.
    """

    def __init__(self, config: Filter, dt: float):
        self.steps = round(config.delay_s / dt)
        """How many samples late the base's are."""
        self._dt = dt
        self._motion = _chain_gain(
            config.position_noise_m, config.velocity_noise_m_s, config.disturbance_m_s3, dt
        )
        self._rotation = _chain_gain(
            config.attitude_noise_rad, config.rate_noise_rad_s, config.disturbance_rad_s3, dt
        )
        r, q = config.joint_noise_rad**2, JOINT_WALK_RAD**2
        P = (q + np.sqrt(q**2 + 4 * q * r)) / 2
        self._joint = P / (P + r)

    def correct(self, predicted: Estimate, sample: VehicleState) -> Estimate:
        """The estimate at a sample's own time, from the one predicted for it."""
        x, L, M = predicted.state, self._motion, self._rotation
        p, v = sample.p_B - x.p_B, sample.v_B - x.v_B
        R = x.R_B
        turn = AngleAxis(R.T @ sample.R_B)
        theta = turn.axis() * turn.angle()
        omega = R.T @ (sample.omega_W - x.omega_W)
        correction = M @ np.stack([theta, omega])
        turned = _turned(x.quaternion, correction[0])
        state = replace(
            x,
            quaternion=turned,
            p_B=x.p_B + L[0] @ [p, v],
            v_B=x.v_B + L[1] @ [p, v],
            omega_W=x.omega_W + R @ correction[1],
        )
        return Estimate(state, predicted.d + L[2] @ [p, v], predicted.delta + correction[2])

    def follow(self, now: Estimate, acceleration: np.ndarray) -> Estimate:
        """The estimate of the base one sample later.

        Args:
            now: Its joints are left as they are.
            acceleration: (6,) m/s^2 in the world and rad/s^2 in the base frame,
                modelled, held until then.
        """
        x, dt = now.state, self._dt
        a, R = acceleration[:3] + now.d, x.R_B
        omega = R.T @ x.omega_W
        alpha = acceleration[3:] + now.delta
        turned = _turned(x.quaternion, dt * omega + dt**2 / 2 * alpha)
        rotated = replace(x, quaternion=turned)
        state = replace(
            rotated,
            p_B=x.p_B + dt * x.v_B + dt**2 / 2 * a,
            v_B=x.v_B + dt * a,
            omega_W=rotated.R_B @ (omega + dt * alpha),
        )
        return Estimate(state, now.d, now.delta)

    def joints(self, q: np.ndarray, rate: np.ndarray, sample: VehicleState) -> np.ndarray:
        """(n,) rad, joint angles at a sample, which is never late.

        Args:
            q: (n,) rad, the estimate at the sample before.
            rate: (n,) rad/s, measured then.
            sample: Measured now.
        """
        predicted = q + self._dt / 2 * (rate + sample.qdot)
        return predicted + self._joint * (sample.q - predicted)


def _chain_gain(value: float, rate: float, walk: float, dt: float) -> np.ndarray:
    """(3, 2) of [x, x', d] for measured [x, x'], both with noise, and d that walks.

    Args:
        value: Standard deviation of the noise on x.
        rate: Likewise of x'.
        walk: Of d, per square root of a second.
        dt: s.
    """
    F = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
    H = np.eye(2, 3)
    G = np.array([dt**2 / 6, dt / 2, 1]) * walk * np.sqrt(dt)
    R = np.diag(np.square([value, rate]))
    P = solve_discrete_are(F.T, H.T, np.outer(G, G), R)
    return P @ H.T @ np.linalg.inv(H @ P @ H.T + R)


def _turned(quaternion: np.ndarray, by: np.ndarray) -> np.ndarray:
    """(4,) the attitude turned by a rotation vector (3,) in its own frame."""
    angle = np.linalg.norm(by)
    axis = by / angle if angle > 1e-12 else np.array([1.0, 0.0, 0.0])
    unit = quaternion / np.linalg.norm(quaternion)
    return Quaternion(unit).multiply(AngleAxis(angle, axis).quaternion()).wxyz()

"""The state of the vehicle now, from noisy samples that come late."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are

from aerodrake.compiled import compiled
from aerodrake.model.rotation import (
    apply,
    conjugate,
    product,
    rotation_matrix,
    rotation_vector,
    turned,
)
from aerodrake.model.vehicle_state import parts
from aerodrake.scenario import Filter

JOINT_WALK_RAD = 1e-4
"""Standard deviation, per sample, of what the measured joint rates miss of the joints' motion."""


class StateFilter(NamedTuple):
    """Steady-state Kalman filters of the base's motion, of its rotation, and of the joints.

    Motion along each axis is the chain p' = v, v' = a + d, d' = noise, of which
    p and v are measured, and a is what the flight controller believes of its
    command. Rotation about each axis is the same chain, with attitude errors as
    rotation vectors in the base frame. Each joint is q' = q_m' + noise. Gains
    follow from the scenario's noise by the Riccati equation once and for all.

    Base samples that are late are met with the estimate of their own time, from
    which the modelled accelerations since then lead to the present.

    An estimate is a vector (19 + 2 n,), [d, delta, x]: d, m/s^2, is the acceleration of
    the base beyond the modelled one, in the world; delta, rad/s^2, the same of its
    rotation, in the base frame; x what would be measured, as `VehicleState` has it.

    Attributes:
        motion: (3, 2) gains of [p, v, d] for [p, v] as measured.
        rotation: (3, 2) likewise of [attitude, rate, delta].
        joint: Gain of a joint's angle.
        steps: How many samples late the base's are.
        dt: s, between samples.
    """

    motion: np.ndarray
    rotation: np.ndarray
    joint: float
    steps: int
    dt: float

    @classmethod
    def make(cls, config: Filter, dt: float) -> StateFilter:
        """For noise of samples and disturbances, and lateness, of the scenario."""
        r, q = config.joint_noise_rad**2, JOINT_WALK_RAD**2
        P = (q + np.sqrt(q**2 + 4 * q * r)) / 2
        return cls(
            motion=_chain_gain(
                config.position_noise_m, config.velocity_noise_m_s, config.disturbance_m_s3, dt
            ),
            rotation=_chain_gain(
                config.attitude_noise_rad, config.rate_noise_rad_s, config.disturbance_rad_s3, dt
            ),
            joint=float(P / (P + r)),
            steps=round(config.delay_s / dt),
            dt=dt,
        )


@compiled
def update(
    gains: StateFilter, memory: np.ndarray, acceleration: np.ndarray, sample: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Takes in a sample.

    One that is not finite corrects nothing: the base goes on as modelled, and the
    arm stays where it was.

    Args:
        gains: And lateness.
        memory: (19 + 2 n + 6 steps,) the last one: estimate of the base at its last
            sample and of the joints, and the accelerations from then on.
        acceleration: (6,) modelled, since the sample before this one, as in `follow`.
        sample: (13 + 2 n,) of the base, late, and of the joints.

    Returns:
        The memory now, and the estimate (19 + 2 n,) as of now.
    """
    size = 6 + len(sample)
    since = np.concatenate((memory[size:], acceleration))
    then = follow(gains, memory[:size], since[:6])
    if np.all(np.isfinite(sample)):
        then = correct(gains, then, sample)
    else:
        qdot = parts(then[6:])[-1]
        qdot[:] = 0.0
    now = then
    for k in range(6, len(since), 6):
        now = follow(gains, now, since[k : k + 6])
    return np.concatenate((then, since[6:])), now


@compiled
def follow(gains: StateFilter, estimate: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """The estimate (19 + 2 n,) one sample later, joints left as they are.

    Args:
        gains: Of which dt.
        estimate: (19 + 2 n,)
        acceleration: (6,) m/s^2 in the world and rad/s^2 in the base frame,
            modelled, held until then.
    """
    dt, later = gains.dt, estimate.copy()
    d, delta = estimate[:3], estimate[3:6]
    quaternion, p_B, _, omega_W, v_B, _ = parts(later[6:])
    turn, omega = np.empty(3), apply(rotation_matrix(quaternion).T, omega_W)
    for i in range(3):
        a, alpha = acceleration[i] + d[i], acceleration[3 + i] + delta[i]
        p_B[i] += dt * v_B[i] + dt**2 / 2 * a
        v_B[i] += dt * a
        turn[i] = dt * omega[i] + dt**2 / 2 * alpha
        omega[i] += dt * alpha
    quaternion[:] = turned(quaternion, turn)
    omega_W[:] = apply(rotation_matrix(quaternion), omega)
    return later


@compiled
def correct(gains: StateFilter, predicted: np.ndarray, sample: np.ndarray) -> np.ndarray:
    """The estimate (19 + 2 n,) at a sample's own time.

    Args:
        gains: Of all.
        predicted: (19 + 2 n,) for the base at that time; its joints are still those
            of the sample before, and move at the mean of both measured rates.
        sample: (13 + 2 n,)
    """
    found = predicted.copy()
    d, delta = found[:3], found[3:6]
    quaternion, p_B, q, omega_W, v_B, qdot = parts(found[6:])
    quaternion_m, p_m, q_m, omega_m, v_m, qdot_m = parts(sample)

    R = rotation_matrix(quaternion)
    turn = rotation_vector(product(conjugate(quaternion), quaternion_m))
    omega, omega_m = apply(R.T, omega_W), apply(R.T, omega_m)
    L, M = gains.motion, gains.rotation
    for i in range(3):
        p, v = p_m[i] - p_B[i], v_m[i] - v_B[i]
        p_B[i] += L[0, 0] * p + L[0, 1] * v
        v_B[i] += L[1, 0] * p + L[1, 1] * v
        d[i] += L[2, 0] * p + L[2, 1] * v
        theta, rate = turn[i], omega_m[i] - omega[i]
        turn[i] = M[0, 0] * theta + M[0, 1] * rate
        omega[i] += M[1, 0] * theta + M[1, 1] * rate
        delta[i] += M[2, 0] * theta + M[2, 1] * rate
    quaternion[:] = turned(quaternion, turn)
    omega_W[:] = apply(R, omega)
    for i in range(len(q)):
        q[i] += gains.dt / 2 * (qdot[i] + qdot_m[i])
        q[i] += gains.joint * (q_m[i] - q[i])
        qdot[i] = qdot_m[i]
    return found


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

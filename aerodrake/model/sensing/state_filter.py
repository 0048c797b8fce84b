"""The state of the vehicle now, from noisy samples that come late."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are

from aerodrake.model.sensing.sample import ATTITUDE, JOINTS, POSITION, group_of
from aerodrake.model.sensing.sample_check import SampleCheck, Verdict, check, is_outage
from aerodrake.model.sensing.sample_check import initial_memory as initial_check_memory
from aerodrake.model.vehicle.rotation import (
    apply,
    conjugate,
    product,
    rotation_matrix,
    rotation_vector,
    turned,
)
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Filter
from aerodrake.support.compiled import compiled

JOINT_WALK_RAD = 1e-4
"""Standard deviation, per sample, of what the measured joint rates miss of the joints' motion."""

ARM_DECAY_S = 0.1
"""In which the arm, while no samples of it come, is believed to come to its setpoints."""


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
        """For noise of samples and disturbances, and lateness, of the scenario; dt in s."""
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


def initial_memory(
    gains: StateFilter, state: np.ndarray, trim_acceleration: np.ndarray
) -> np.ndarray:
    """What `update` needs at rest at a state (m,), known since a sample before time 0.

    [what the check remembers (2 m + 6), its health (6), the estimate (6 + m) of the base at
    its last sample and of the joints, the accelerations (6 steps) modelled from then on].

    Args:
        gains: Of which lateness.
        state: (13 + 2 n,)
        trim_acceleration: (6,) modelled at rest; what it says is not there.
    """
    checked = initial_check_memory(state, -gains.dt)
    since = np.tile(trim_acceleration, gains.steps)
    return np.concatenate([checked, np.zeros(6), -trim_acceleration, state, since])


@compiled
def update(
    gains: StateFilter,
    bounds: SampleCheck,
    memory: np.ndarray,
    acceleration: np.ndarray,
    sample: np.ndarray,
    stamps: np.ndarray,
    joint_setpoint: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Takes in what is believed of a sample, and goes on with predictions of the rest.

    The base goes on as modelled, and the arm to its setpoints. After an outage the estimate
    is the sample, and goes on with the disturbances that were known: what happened
    meanwhile would be taken for one.

    Args:
        gains: And lateness.
        bounds: Of what is believed.
        memory: The last one, as `initial_memory` has it.
        acceleration: (6,) modelled, since the sample before this one, as in `follow`.
        sample: (13 + 2 n,) of the base, late, and of the joints.
        stamps: (3,) s, when its groups were taken.
        joint_setpoint: (3 n,) now.

    Returns:
        The memory now; the estimate (19 + 2 n,) as of now; health (6,) of the sample.
    """
    m = len(sample)
    judged, known = 2 * m + 6, 2 * m + 12
    since = np.concatenate((memory[known + 6 + m :], acceleration))
    then = follow(gains, memory[known : known + 6 + m], since[:6])
    predicted = arm_follows(gains, then, joint_setpoint)
    ages = memory[judged : judged + 3]
    health, checked = check(bounds, memory[:judged], ages, predicted, sample, stamps)
    for g in range(3):
        if health[3 + g] != Verdict.OK.value:
            if g == JOINTS:
                replace_group(g, then[6:], predicted[6:])
        elif is_outage(bounds, ages[g]):
            replace_group(g, then[6:], sample)
        elif g == POSITION:
            correct_motion(gains, then, sample)
        elif g == ATTITUDE:
            correct_rotation(gains, then, sample)
        else:
            correct_joints(gains, then, sample)
    now = then
    for k in range(6, len(since), 6):
        now = follow(gains, now, since[k : k + 6])
    return np.concatenate((checked, health, then, since[6:])), now, health


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
    quaternion, p_B, _, omega_W, v_B, _ = split_state(later[6:])
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
def arm_follows(gains: StateFilter, estimate: np.ndarray, setpoint: np.ndarray) -> np.ndarray:
    """The estimate (19 + 2 n,) with the arm one sample later, moving as its setpoints do.

    How far it is off them dies down.

    Args:
        gains: Of which dt.
        estimate: (19 + 2 n,), its joints those of the sample before.
        setpoint: (3 n,) q_d, q_d', q_d'' at this sample.
    """
    dt, later = gains.dt, estimate.copy()
    _, _, q, _, _, qdot = split_state(later[6:])
    n, decay = len(q), np.exp(-dt / ARM_DECAY_S)
    for i in range(n):
        q_d, qdot_d, qddot_d = setpoint[i], setpoint[n + i], setpoint[2 * n + i]
        q[i] = q_d + decay * (q[i] - (q_d - dt * qdot_d + dt**2 / 2 * qddot_d))
        qdot[i] = qdot_d + decay * (qdot[i] - (qdot_d - dt * qddot_d))
    return later


@compiled
def correct_motion(gains: StateFilter, estimate: np.ndarray, sample: np.ndarray) -> None:
    """Corrects position, velocity and d of an estimate at a sample's own time.

    Args:
        gains: Of which those of `motion`.
        estimate: (19 + 2 n,), changed in place.
        sample: (13 + 2 n,)
    """
    d, L = estimate[:3], gains.motion
    _, p_B, _, _, v_B, _ = split_state(estimate[6:])
    _, p_m, _, _, v_m, _ = split_state(sample)
    for i in range(3):
        p, v = p_m[i] - p_B[i], v_m[i] - v_B[i]
        p_B[i] += L[0, 0] * p + L[0, 1] * v
        v_B[i] += L[1, 0] * p + L[1, 1] * v
        d[i] += L[2, 0] * p + L[2, 1] * v


@compiled
def correct_rotation(gains: StateFilter, estimate: np.ndarray, sample: np.ndarray) -> None:
    """Corrects attitude, its rate and delta of an estimate at a sample's own time.

    Args:
        gains: Of which those of `rotation`.
        estimate: (19 + 2 n,), changed in place.
        sample: (13 + 2 n,)
    """
    delta, M = estimate[3:6], gains.rotation
    quaternion, _, _, omega_W, _, _ = split_state(estimate[6:])
    quaternion_m, _, _, omega_m, _, _ = split_state(sample)
    R = rotation_matrix(quaternion)
    turn = rotation_vector(product(conjugate(quaternion), quaternion_m))
    omega, omega_m = apply(R.T, omega_W), apply(R.T, omega_m)
    for i in range(3):
        theta, rate = turn[i], omega_m[i] - omega[i]
        turn[i] = M[0, 0] * theta + M[0, 1] * rate
        omega[i] += M[1, 0] * theta + M[1, 1] * rate
        delta[i] += M[2, 0] * theta + M[2, 1] * rate
    quaternion[:] = turned(quaternion, turn)
    omega_W[:] = apply(R, omega)


@compiled
def correct_joints(gains: StateFilter, estimate: np.ndarray, sample: np.ndarray) -> None:
    """Corrects joints of an estimate (19 + 2 n,), as of the sample before, by a sample (13 + 2 n,).

    They have moved at the mean of both measured rates.
    """
    _, _, q, _, _, qdot = split_state(estimate[6:])
    _, _, q_m, _, _, qdot_m = split_state(sample)
    for i in range(len(q)):
        q[i] += gains.dt / 2 * (qdot[i] + qdot_m[i])
        q[i] += gains.joint * (q_m[i] - q[i])
        qdot[i] = qdot_m[i]


@compiled
def passed(sample: np.ndarray, predicted: np.ndarray, health: np.ndarray) -> np.ndarray:
    """(13 + 2 n,) a sample as it is, but for the groups that are not believed.

    Args:
        sample: (13 + 2 n,) as it came.
        predicted: (13 + 2 n,) what such groups are taken from.
        health: (6,) of the sample, as from `check`.
    """
    found = sample.copy()
    for g in range(3):
        if health[3 + g] != Verdict.OK.value:
            replace_group(g, found, predicted)
    return found


@compiled
def replace_group(g: int, x: np.ndarray, by: np.ndarray) -> None:
    """Puts a group of the state `by` in the place of that of the state x, (13 + 2 n,) each."""
    value, rate = group_of(g, x)
    value[:], rate[:] = group_of(g, by)


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

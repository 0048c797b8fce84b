"""Estimate of the vehicle's state and the disturbances on its base: prediction and correction."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.rotation import (
    apply,
    conjugate,
    product,
    rotation_matrix,
    rotation_vector,
    turned,
)
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled

ARM_DECAY_S = 0.1
"""Time constant with which the predicted arm approaches its setpoints."""


class Estimate(NamedTuple):
    """Estimated state of the vehicle and disturbances on its base.

    Attributes:
        disturbance: (6,) acceleration of the base beyond the modelled one: d, m/s^2 in the world,
            and delta, rad/s^2 in the base frame.
        state: (13 + 2 n,), as `VehicleState` has it.
    """

    disturbance: np.ndarray
    state: np.ndarray


@compiled
def predict_base(estimate: Estimate, acceleration: np.ndarray, dt: float) -> Estimate:
    """Returns the estimate one sample later, with its joints unchanged.

    Args:
        estimate: At the sample before.
        acceleration: (6,) m/s^2 in the world and rad/s^2 in the base frame, modelled,
            constant until then.
        dt: s, between samples.
    """
    state, total = estimate.state.copy(), acceleration + estimate.disturbance
    quaternion, p_B, _, omega_W, v_B, _ = split_state(state)
    turn, omega = np.empty(3), apply(rotation_matrix(quaternion).T, omega_W)
    for i in range(3):
        a, alpha = total[i], total[3 + i]
        p_B[i] += dt * v_B[i] + dt**2 / 2 * a
        v_B[i] += dt * a
        turn[i] = dt * omega[i] + dt**2 / 2 * alpha
        omega[i] += dt * alpha
    quaternion[:] = turned(quaternion, turn)
    omega_W[:] = apply(rotation_matrix(quaternion), omega)
    return Estimate(estimate.disturbance.copy(), state)


@compiled
def predict_arm(estimate: Estimate, setpoint: np.ndarray, dt: float) -> Estimate:
    """Returns the estimate with its arm one sample later.

    The arm moves as its setpoints do; its deviation from them decays exponentially.

    Args:
        estimate: Its joints are those of the sample before.
        setpoint: (3 n,) q_d, q_d', q_d'' at this sample.
        dt: s, between samples.
    """
    state = estimate.state.copy()
    _, _, q, _, _, qdot = split_state(state)
    n, decay = len(q), np.exp(-dt / ARM_DECAY_S)
    for i in range(n):
        q_d, qdot_d, qddot_d = setpoint[i], setpoint[n + i], setpoint[2 * n + i]
        q[i] = q_d + decay * (q[i] - (q_d - dt * qdot_d + dt**2 / 2 * qddot_d))
        qdot[i] = qdot_d + decay * (qdot[i] - (qdot_d - dt * qddot_d))
    return Estimate(estimate.disturbance, state)


@compiled
def correct_position(estimate: Estimate, sample: np.ndarray, L: np.ndarray) -> None:
    """Corrects position, velocity and d at the time of a sample (13 + 2 n,), in place.

    L (3, 2) has the gains of [p, v, d] for [p, v] as measured.
    """
    d = estimate.disturbance[:3]
    _, p_B, _, _, v_B, _ = split_state(estimate.state)
    _, p_m, _, _, v_m, _ = split_state(sample)
    for i in range(3):
        p, v = p_m[i] - p_B[i], v_m[i] - v_B[i]
        p_B[i] += L[0, 0] * p + L[0, 1] * v
        v_B[i] += L[1, 0] * p + L[1, 1] * v
        d[i] += L[2, 0] * p + L[2, 1] * v


@compiled
def correct_attitude(estimate: Estimate, sample: np.ndarray, L: np.ndarray) -> None:
    """Corrects attitude, angular velocity and delta at the time of a sample (13 + 2 n,), in place.

    L (3, 2) has the gains of [attitude, rate, delta] for [attitude, rate] as measured.
    """
    delta = estimate.disturbance[3:]
    quaternion, _, _, omega_W, _, _ = split_state(estimate.state)
    quaternion_m, _, _, omega_m, _, _ = split_state(sample)
    R = rotation_matrix(quaternion)
    turn = rotation_vector(product(conjugate(quaternion), quaternion_m))
    omega, omega_m = apply(R.T, omega_W), apply(R.T, omega_m)
    for i in range(3):
        theta, rate = turn[i], omega_m[i] - omega[i]
        turn[i] = L[0, 0] * theta + L[0, 1] * rate
        omega[i] += L[1, 0] * theta + L[1, 1] * rate
        delta[i] += L[2, 0] * theta + L[2, 1] * rate
    quaternion[:] = turned(quaternion, turn)
    omega_W[:] = apply(R, omega)


@compiled
def correct_acceleration(
    estimate: Estimate,
    specific_force: np.ndarray,
    acceleration: np.ndarray,
    gain: np.ndarray,
    dt: float,
) -> None:
    """Corrects position, velocity and d by a measured specific force, in place.

    Args:
        estimate: At the end of the time over which the force is the mean.
        specific_force: (3,) m/s^2, in the base frame.
        acceleration: (6,) modelled during that time, as in `predict_base`.
        gain: (3,) of [p, v, d] for d as measured.
        dt: s, the time.
    """
    d = estimate.disturbance[:3]
    quaternion, p_B, _, omega_W, v_B, _ = split_state(estimate.state)
    omega = apply(rotation_matrix(quaternion).T, omega_W)
    R = rotation_matrix(turned(quaternion, -dt / 2 * omega))  # Halfway.
    measured = apply(R, specific_force)
    measured[2] -= GRAVITY
    for i in range(3):
        error = measured[i] - acceleration[i] - d[i]
        p_B[i] += gain[0] * error
        v_B[i] += gain[1] * error
        d[i] += gain[2] * error


@compiled
def correct_joints(estimate: Estimate, sample: np.ndarray, gain: float, dt: float) -> None:
    """Predicts the joints by the mean of both measured rates, and corrects them, in place.

    Args:
        estimate: Its joints are those of the sample before.
        sample: (13 + 2 n,) as measured.
        gain: Gain of a joint's angle.
        dt: s, between samples.
    """
    _, _, q, _, _, qdot = split_state(estimate.state)
    _, _, q_m, _, _, qdot_m = split_state(sample)
    for i in range(len(q)):
        q[i] += dt / 2 * (qdot[i] + qdot_m[i])
        q[i] += gain * (q_m[i] - q[i])
        qdot[i] = qdot_m[i]

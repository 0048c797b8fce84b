"""Features and targets of the residual network from a recorded flight."""

from __future__ import annotations

import numpy as np

from aerodrake.model.equivalent.initial_state import Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import feature_names, features
from aerodrake.model.vehicle.state import split_state

Samples = tuple[np.ndarray, np.ndarray]
"""(T, 12 + 3 n) features and (T, 3) m/s targets of one flight."""


def residual_samples(
    model: EquivalentModel,
    state: np.ndarray,
    base_setpoint: np.ndarray,
    joint_setpoint: np.ndarray,
    specific_thrust: np.ndarray,
    external_acceleration: np.ndarray,
    disturbance: np.ndarray,
) -> Samples:
    """What the residual estimator would have seen, at the ticks k = 1 ... T-2.

    The features of the sample k are those of the state measured at t_k and of
    u_{k-1}; its target is the velocity measured at t_{k+1} minus the one that the
    model predicts from x_k under u_k without Delta. The first and the last tick
    have no sample of their own, for want of u_{k-1} and of the next velocity; the
    model's hidden states begin at the first tick all the same.

    Args:
        model: Whose residual it is; its period is that of the ticks.
        state: (T, 13 + 2 n) measured `VehicleState` at each tick, T >= 3.
        base_setpoint: (T, 9) [p_d, v_d, a_d] in m, m/s, m/s^2, with the a_d that
            is held from the tick on.
        joint_setpoint: (T, 3 n) [q_d, q_d', q_d''] in rad, rad/s, rad/s^2, alike.
        specific_thrust: (T, 1) m/s^2, of the flight controller.
        external_acceleration: (T, 3) m/s^2, of the state filter.
        disturbance: (T, 6) of the flight controller, m/s^2 first.

    Returns:
        (T-2, 12 + 3 n) features, unscaled, and (T-2, 3) m/s, targets.
    """
    n, samples = model.joints, len(state) - 2
    u = np.hstack([base_setpoint[:, 6:], joint_setpoint[:, 2 * n :]])
    seen, targets = np.empty((samples, len(feature_names(n)))), np.empty((samples, 3))
    x = None  # At the first tick, which therefore asks for no u_{k-1}.
    for k in range(samples + 1):
        now, after = (split_state(row) for row in state[k : k + 2])
        x = model.initial_state(
            now.p_B,
            now.v_B,
            np.concatenate([base_setpoint[k, :6], u[k - 1, :3]]),
            np.concatenate([joint_setpoint[k, : 2 * n], u[k - 1, 3:]]),
            Thrust.make(now, specific_thrust[k, 0], external_acceleration[k], disturbance[k]),
            x,
        )
        if k > 0:
            seen[k - 1] = features(state[k], u[k - 1])
            targets[k - 1] = after.v_B - model.next_velocity(x, u[k])
    return seen, targets

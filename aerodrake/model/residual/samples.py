"""Features and targets of the residual network from a recorded flight."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.equivalent.initial_state import Signals, Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import feature_names, features
from aerodrake.model.vehicle.state import split_state

Samples = tuple[np.ndarray, np.ndarray]
"""(T, 12 + 3 n) features and (T, 3) m/s targets, true c Delta, of one flight at each of T ticks."""


class Excitation(NamedTuple):
    """Measurements and setpoints of an open-loop flight, one row for each tick of the model.

    Attributes:
        time_s: (T,) 0, period, 2 period, ...
        state: (T, 13 + 2 n) measured `VehicleState`.
        specific_thrust: (T, 1) m/s^2, output of the flight controller.
        external_acceleration: (T, 3) m/s^2, output of the state filter.
        disturbance: (T, 6) m/s^2 and rad/s^2, output of the flight controller.
        base_setpoint: (T, 9) p_d, v_d, and a_d until the next tick, in m, m/s, m/s^2.
        joint_setpoint: (T, 3 n) q_d, q_d' and q_d'' likewise, in rad, rad/s, rad/s^2.
    """

    time_s: np.ndarray
    state: np.ndarray
    specific_thrust: np.ndarray
    external_acceleration: np.ndarray
    disturbance: np.ndarray
    base_setpoint: np.ndarray
    joint_setpoint: np.ndarray


def residual_samples(model: EquivalentModel, flight: Excitation) -> Samples:
    """Returns the samples of the residual estimator along a recorded flight, k = 1 ... T-2.

    The features of the sample k are from the state measured at t_k and u_{k-1}, unscaled; its
    target is the velocity measured at t_{k+1} minus the one that the model predicts from x_k
    under u_k without Delta: c Delta, with c its `residual_gain`. The first tick has no sample,
    since u_{k-1} is unknown; nor has the last, since the next velocity is unknown. The model's
    hidden states start at the first tick.

    Args:
        model: Equivalent model with the period of the ticks.
        flight: The recorded flight, of T >= 3 ticks.
    """
    _, state, specific_thrust, external, disturbance, base, joints = flight
    n, samples = model.joints, len(state) - 2
    u = np.hstack([base[:, 6:], joints[:, 2 * n :]])
    inputs, targets = np.empty((samples, len(feature_names(n)))), np.empty((samples, 3))
    x = None  # Without an x before, the first tick uses no u_{k-1}.
    for k in range(samples + 1):
        now, after = (split_state(row) for row in state[k : k + 2])
        thrust = Thrust.make(now, specific_thrust[k, 0], external[k], disturbance[k])
        base_setpoint = np.concatenate([base[k, :6], u[k - 1, :3]])
        joint_setpoint = np.concatenate([joints[k, : 2 * n], u[k - 1, 3:]])
        signals = Signals(now.p_B, now.v_B, base_setpoint, joint_setpoint, thrust)
        x = model.initial_state(signals, x)
        if k > 0:
            inputs[k - 1] = features(state[k], u[k - 1])
            targets[k - 1] = after.v_B - model.next_velocity(x, u[k])
    return inputs, targets

"""Models of one axis of the base and its response to the setpoint: x+ = A x + B u + C Delta.

The states of an axis begin with position, velocity, and those of the setpoint,
[p, p', p_d, p_d']; u is the acceleration of the setpoint.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from aerodrake.scenario import Flight, Rotor

STATES = ("p", "v", "p_d", "v_d")
"""Position and velocity of an axis and of its setpoint, in m and m/s."""

THRUST_STATES = ("b", "d", "h", "r", "alpha", "w")
"""States of an axis beyond `STATES`, as in `flight_axis`."""

HIDDEN_STATES = ("alpha", "w")
"""States that are not measured; the model predicts them from tick to tick."""

TILT_AXES = (1, 0)
"""Axes about which the base tilts to accelerate along x and along y."""


class ResidualQuantity(NamedTuple):
    """Physical quantity that Delta is in a model.

    Attributes:
        name: Name of the quantity.
        unit: Its SI unit.
        log_key: Key of Delta in the log.
    """

    name: str
    unit: str
    log_key: str


RESIDUAL_VELOCITY = ResidualQuantity("residual velocity", "m/s", "delta_m_s")
"""Delta of the models with K_B alone (paper, eq. 3)."""

RESIDUAL_ACCELERATION = ResidualQuantity("residual acceleration", "m/s^2", "delta_m_s2")
"""Delta of the flight model."""


class AxisModel(NamedTuple):
    """Linear model of one axis with m states.

    Attributes:
        A: (m, m).
        B: (m,).
        C: (m,), effect of a Delta that is constant over the period.
        states: Names of the m states, `STATES` first.
        acceleration: (m,), maps the states to the acceleration that tilts the base; zero in
            models that do not describe it.
        residual: Quantity that Delta is.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    states: tuple[str, ...]
    acceleration: np.ndarray
    residual: ResidualQuantity = RESIDUAL_VELOCITY


def paper_axis(k: float, dt: float) -> AxisModel:
    """Returns p' = k (p_d - p) + Delta by semi-implicit Euler, as printed; k in 1/s, dt in s.

    The printed `k delta^2` of A_1 is read as k dt^2. The second column of A is zero: the measured
    velocity has no effect on the prediction except through Delta.
    """
    A = np.array(
        [
            [1 - k * dt, 0, k * dt, k * dt**2],
            [-k, 0, k, k * dt],
            [0, 0, 1, dt],
            [0, 0, 0, 1],
        ]
    )
    B = np.array([k * dt**3 / 2, k * dt**2 / 2, dt**2 / 2, dt])
    return _first_order(k, A, B, np.array([dt, 1, 0, 0]))


def exact_axis(k: float, dt: float) -> AxisModel:
    """Returns p' = k (p_d - p) + Delta (paper, eq. 3), exact for u and Delta constant over dt.

    k in 1/s, dt in s.
    """
    E = math.exp(-k * dt)
    g = (1 - E) / k
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    p = np.array([E, 0, 1 - E, dt - g])
    p_u = dt**2 / 2 - dt / k + g / k
    A = np.vstack([p, k * (setpoint[0] - p), setpoint])
    B = np.array([p_u, k * (input_[0] - p_u), *input_])
    return _first_order(k, A, B, np.array([g, E, 0, 0]))


def velocity_aware_axis(k: float, dt: float) -> AxisModel:
    """Returns p' = p_d' + k (p_d - p) + Delta, exact for u and Delta constant over dt.

    It models a flight controller with the inputs p_d, p_d' and p_d''. k in 1/s, dt in s.
    """
    E = math.exp(-k * dt)
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    p = setpoint[0] + np.array([E, 0, -E, 0])
    A = np.vstack([p, setpoint[1] + k * (setpoint[0] - p), setpoint])
    B = np.array([*input_, *input_])
    return AxisModel(A, B, np.array([(1 - E) / k, E, 0, 0]), STATES, np.zeros(4))


def integral_axis(k: float, dt: float) -> AxisModel:
    """Returns the baseline model: the base is at its setpoint; dt in s, k unused."""
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    A, B = np.vstack([setpoint, setpoint]), np.array([*input_, *input_])
    return AxisModel(A, B, np.zeros(4), STATES, np.zeros(4))


def _first_order(k: float, A: np.ndarray, B: np.ndarray, C: np.ndarray) -> AxisModel:
    """Returns the axis with its own acceleration, p'' = k (p_d' - p')."""
    return AxisModel(A, B, C, STATES, np.array([0, -k, 0, k]))


def flight_axis(axis: int, flight: Flight, rotor: Rotor, period: float, dt: float) -> AxisModel:
    """Returns the linear flight model, exact for u and Delta constant over dt.

    Thrust accelerates the base by b: along x and y through tilt, along z through its magnitude.
    All other forces accelerate it by d + Delta: d is the constant acceleration that the
    state filter estimates, Delta the residual acceleration, in m/s^2, that it does not. The
    flight controller's ESO estimates d + Delta as h; a first-order lag with the rate w_o / 3 has
    the same mean delay as the observer's three poles at -w_o. With a_c the acceleration that the
    position law commands,

        p'' = b + d + Delta,    h' = (d + Delta - h) w_o / 3,
        a_c = k_p (p_d - p) + k_v (p_d' - p') + u - h

    (a_c = k_p (p_d - p) - k_v p' - h with the `position` interface). Along z
    thrust follows with the rotors' lag tau, b' = (a_c - b) / tau. Along x and
    y the attitude law controls the tilt through the same lag, with the filtered rate of
    the desired tilt as feedforward (time constant T_f):

        b' = r,    r' = alpha,
        alpha' = (k_R (a_c - b) + k_omega (a_c' / (1 + T_f s) - r) - alpha) / tau.

    w = a_c' / (1 + T_f s) - a_c / T_f is the filter's state, with w' = -(w + a_c / T_f) / T_f. It
    is continuous although a_c jumps with u, and depends on Delta only through p, p' and h. For
    small tilt and yaw the axes are decoupled.

    Args:
        axis: 0, 1 or 2.
        flight: Gains and interface.
        rotor: Lag; the model takes the mean of rise and fall. The surplus in the mean
            thrust by unequal lags is part of d.
        period: s, of the flight controller; its zero-order hold delays thrust by half of it.
        dt: s.
    """
    tau = (rotor.lag_up_s + rotor.lag_down_s) / 2 + period / 2
    T_f = flight.rate_filter_s + period  # Of the filter's discrete form.
    k_p, k_v = flight.position_gain[axis], flight.velocity_gain[axis]
    states = (*STATES, *THRUST_STATES)
    size = len(states) + 2
    p, v, p_d, v_d, b, d, h, r, alpha, w, u, delta = np.eye(size)
    a_c = k_p * (p_d - p) - k_v * v - h
    if flight.interface == "trajectory":
        a_c = a_c + k_v * v_d + u
    h_rate = flight.position_eso_rad_s / 3 * (d + delta - h)
    zero = np.zeros(size)
    if axis < len(TILT_AXES):
        about = TILT_AXES[axis]
        k_R, k_omega = flight.attitude_gain[about], flight.rate_gain[about]
        command = k_R * (a_c - b) + k_omega * (w + a_c / T_f - r)
        thrust = (r, zero, h_rate, alpha, (command - alpha) / tau, -(w + a_c / T_f) / T_f)
    else:
        thrust = ((a_c - b) / tau, zero, h_rate, zero, zero, zero)
    rates = np.array([v, b + d + delta, v_d, u, *thrust, zero, zero])
    A, B, C = np.split(expm(dt * rates)[:-2], [-2, -1], axis=1)
    return AxisModel(A, B[:, 0], C[:, 0], states, b[:-2], RESIDUAL_ACCELERATION)


AXIS_MODELS: dict[str, Callable[[float, float], AxisModel]] = {
    "paper": paper_axis,
    "exact": exact_axis,
    "velocity_aware": velocity_aware_axis,
    "integral": integral_axis,
}
"""Models by the scenario's `model.kind`, functions of k [1/s] and dt [s]."""

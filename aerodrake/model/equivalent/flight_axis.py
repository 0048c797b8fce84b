"""Model of one axis of the base in closed loop with its flight controller."""

import numpy as np
from scipy.linalg import expm

from aerodrake.model.equivalent.axis_models import STATES, AxisModel
from aerodrake.scenario import Flight, Rotor

THRUST_STATES = ("b", "d", "h", "r", "alpha", "w")
"""States of an axis beyond `STATES`, as in `flight_axis`."""

HIDDEN_STATES = ("alpha", "w")
"""States that are not measured; the model predicts them from tick to tick."""

UPRIGHT_AXES = (1, 0)
"""Axes about which the base tilts to accelerate along x and along y."""


def flight_axis(axis: int, flight: Flight, rotor: Rotor, period: float, dt: float) -> AxisModel:
    """Returns the linear flight model, exact for u and Delta constant over dt.

    Thrust accelerates the base by b: along x and y through tilt, along z through its magnitude.
    All other forces accelerate it by d, which is constant. The flight controller's ESO estimates
    d as h, which follows d at a third of the observer's bandwidth w_o, the mean of its three
    poles. With a_c the acceleration that the position law commands,

        p'' = b + d,    h' = (d - h) w_o / 3,
        a_c = k_p (p_d - p) + k_v (p_d' - p') + u - h

    (a_c = k_p (p_d - p) - k_v p' - h with the `position` interface). Along z
    thrust follows with the rotors' lag tau, b' = (a_c - b) / tau. Along x and
    y the attitude law controls the tilt through the same lag, with the filtered rate of
    the desired tilt as feedforward (time constant T_f):

        b' = r,    r' = alpha,
        alpha' = (k_R (a_c - b) + k_omega (a_c' / (1 + T_f s) - r) - alpha) / tau.

    w = a_c' / (1 + T_f s) - a_c / T_f is the filter's state, which is continuous although a_c
    jumps with u. For small tilt and yaw the axes are decoupled.

    Args:
        axis: 0, 1 or 2.
        flight: Gains and interface.
        rotor: Lag; the model takes the mean of rise and fall.
        period: s, of the flight controller; its zero-order hold delays thrust by half of it.
        dt: s.
    """
    tau = (rotor.lag_up_s + rotor.lag_down_s) / 2 + period / 2
    T_f = flight.rate_filter_s + period  # Of the filter's discrete form.
    k_p, k_v = flight.position_gain[axis], flight.velocity_gain[axis]
    names = (*STATES, *THRUST_STATES, "u")
    p, v, p_d, v_d, b, d, h, r, alpha, w, u = np.eye(len(names))
    a_c = k_p * (p_d - p) - k_v * v - h
    if flight.interface == "trajectory":
        a_c = a_c + k_v * v_d + u
    h_rate = flight.position_eso_rad_s / 3 * (d - h)
    zero = np.zeros(len(names))
    if axis < len(UPRIGHT_AXES):
        about = UPRIGHT_AXES[axis]
        k_R, k_omega = flight.attitude_gain[about], flight.rate_gain[about]
        command = k_R * (a_c - b) + k_omega * (w + a_c / T_f - r)
        thrust = (r, zero, h_rate, alpha, (command - alpha) / tau, -(w + a_c / T_f) / T_f)
    else:
        thrust = ((a_c - b) / tau, zero, h_rate, zero, zero, zero)
    transition = expm(dt * np.array([v, b + d, v_d, u, *thrust, zero]))[:-1]
    states = names[:-1]
    C = np.zeros(len(states))
    C[:2] = dt / 2, 1
    return AxisModel(transition[:, :-1], transition[:, -1], C, states, b[:-1])

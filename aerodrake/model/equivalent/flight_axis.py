"""One axis of the base under its flight controller: the closed loop as it is."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from aerodrake.model.equivalent.axis_models import STATES, AxisModel
from aerodrake.scenario import Flight, Rotor

THRUST_STATES = ("b", "d", "h", "r", "alpha", "w")
"""Those of an axis beyond its setpoint's, as in `flight_axis`."""

HIDDEN_STATES = ("alpha", "w")
"""Those that nobody measures: they follow the model from one tick to the next."""

UPRIGHT_AXES = (1, 0)
"""About which axis of the base it turns to accelerate along x, and along y."""


def flight_axis(axis: int, flight: Flight, rotor: Rotor, period: float, dt: float) -> AxisModel:
    """The linear flight model, exact for u and Delta held over dt.

    Thrust gives the base the acceleration b, by its tilt along x and y, by its
    size along z. What else accelerates it is d, and constant; the flight
    controller's ESO takes h for it, which follows d at a third of the observer's
    bandwidth w_o, as its three poles do in the mean. With a_c what the position
    law asks of thrust,

        p'' = b + d,    h' = (d - h) w_o / 3,
        a_c = k_p (p_d - p) + k_v (p_d' - p') + u - h

    (a_c = k_p (p_d - p) - k_v p' - h with the `position` interface). Along z
    thrust follows with the rotors' lag tau, b' = (a_c - b) / tau. Along x and
    y the attitude law makes the tilt follow through the same lag, fed forward
    with the rate of the desired tilt, filtered with T_f:

        b' = r,    r' = alpha,
        alpha' = (k_R (a_c - b) + k_omega (a_c' / (1 + T_f s) - r) - alpha) / tau.

    w = a_c' / (1 + T_f s) - a_c / T_f stands for the filter's state, since a_c
    jumps with u. The small angles of x and y do not mix as long as yaw is small.

    Args:
        axis: 0, 1 or 2.
        flight: Gains and interface.
        rotor: Lag, of which the mean of rise and fall is taken.
        period: s, of the flight controller, whose thrust is held so long: that
            is half of it later in the mean.
        dt: s.
    """
    tau = (rotor.lag_up_s + rotor.lag_down_s) / 2 + period / 2
    T_f = flight.rate_filter_s + period  # As the filter's discrete form has it.
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
        wanted = k_R * (a_c - b) + k_omega * (w + a_c / T_f - r)
        thrust = (r, zero, h_rate, alpha, (wanted - alpha) / tau, -(w + a_c / T_f) / T_f)
    else:
        thrust = ((a_c - b) / tau, zero, h_rate, zero, zero, zero)
    exact = expm(dt * np.array([v, b + d, v_d, u, *thrust, zero]))[:-1]
    states = names[:-1]
    C = np.zeros(len(states))
    C[:2] = dt / 2, 1
    return AxisModel(exact[:, :-1], exact[:, -1], C, states, b[:-1])

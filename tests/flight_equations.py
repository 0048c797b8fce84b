"""Differential equations of the flight model, along one axis, without its matrices."""

from typing import NamedTuple

import numpy as np

STATES = ("p", "v", "p_d", "v_d", "b", "d", "h", "r", "alpha", "low")
"""States of the equations; `low` is the low-passed a_c, w = -low / T_f."""


class AxisLoop(NamedTuple):
    """Gains and time constants along one axis; only x and y have attitude gains.

    Attributes:
        interface: `trajectory` or `position`.
        k_p, k_v: 1/s^2 and 1/s.
        k_R, k_omega: 1/s^2 and 1/s, of the axis about which the base tilts; None along z.
        tau: s, lag of the rotors.
        T_f: s, of the filtered rate.
        h_rate: 1/s, of the observer.
    """

    interface: str
    k_p: float
    k_v: float
    k_R: float | None
    k_omega: float | None
    tau: float
    T_f: float
    h_rate: float

    def slope(self, y: np.ndarray, u: float, delta: float) -> np.ndarray:
        """Returns the rates (10,) of `STATES` under the input u and the residual acceleration."""
        p, v, p_d, v_d, b, d, h, r, alpha, low = y
        a_c = self.k_p * (p_d - p) - self.k_v * v - h
        if self.interface == "trajectory":
            a_c += self.k_v * v_d + u
        external = d + delta
        motion = [v, b + external, v_d, u]
        h_slope = self.h_rate * (external - h)
        if self.k_R is None:
            return np.array([*motion, (a_c - b) / self.tau, 0, h_slope, 0, 0, 0])
        rate = (a_c - low) / self.T_f
        torque = self.k_R * (a_c - b) + self.k_omega * (rate - r)
        return np.array([*motion, r, 0, h_slope, alpha, (torque - alpha) / self.tau, rate])

"""Discrete PID of the arm's joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Arm


@dataclass(frozen=True)
class JointPid:
    """torque = k_p e + k_d e' + integral, within limits, without windup.

    Attributes:
        k_p: (n,) N m/rad.
        k_d: (n,) N m s/rad.
        k_i: (n,) N m/(rad s).
        effort: (n,) N m, torque limits.
        dt: s, period.
    """

    k_p: np.ndarray
    k_d: np.ndarray
    k_i: np.ndarray
    effort: np.ndarray
    dt: float

    @classmethod
    def make(cls, arm: Arm, vehicle: Vehicle, dt: float) -> JointPid:
        """Gains that give each joint's inertia the bandwidth and damping of `arm`."""
        k_p = vehicle.joint_inertia * arm.bandwidth_rad_s**2
        k_d = vehicle.joint_inertia * 2 * arm.damping * arm.bandwidth_rad_s
        return cls(k_p, k_d, k_p * arm.integral_rad_s, vehicle.effort, dt)

    def torque(self, error: np.ndarray, rate_error: np.ndarray, integral: np.ndarray) -> np.ndarray:
        """(n,) N m, for errors (n,) rad and rad/s and the integral (n,) N m."""
        wanted = self.k_p * error + self.k_d * rate_error + integral
        return np.clip(wanted, -self.effort, self.effort)

    def integrate(
        self, error: np.ndarray, rate_error: np.ndarray, integral: np.ndarray
    ) -> np.ndarray:
        """(n,) N m, the integral one period later.

        It holds still where the torque is at its limit and the error would
        drive it further out, and never exceeds the limit by itself.
        """
        wanted = self.k_p * error + self.k_d * rate_error + integral
        winding = (np.abs(wanted) > self.effort) & (wanted * error > 0)
        moved = integral + np.where(winding, 0.0, self.k_i * error * self.dt)
        return np.clip(moved, -self.effort, self.effort)

"""Equivalent kinematic models of the base under its flight controller, and of the arm.

One linear, time-invariant model x+ = A x + B u + C Delta (paper, eq. 5), with

    x = [p_Bx, p_Bx', p_Bx,d, p_Bx,d', p_By, ..., q_1, q_1', ..., q_n, q_n'],
    u = [p_Bx,d'', p_By,d'', p_Bz,d'', q_1'', ..., q_n''],

and Delta the residual velocity of the base. The joints are double integrators
of the command; the four kinds differ in how the base answers its setpoint.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

BASE_STATES = 4
"""States per base axis: position, velocity, and those of the setpoint."""

AxisModel = tuple[np.ndarray, np.ndarray, np.ndarray]
"""A (4, 4), B (4,) and C (4,) of one base axis."""


def paper_axis(k: float, dt: float) -> AxisModel:
    """p' = k (p_d - p) + Delta by semi-implicit Euler, as the paper prints it.

    Its A_1 has `k delta^2` for k delta_t squared. The second column of A is
    zero: measured velocity does not propagate and acts through Delta alone.
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
    return A, B, np.array([dt, 1, 0, 0])


def exact_axis(k: float, dt: float) -> AxisModel:
    """p' = k (p_d - p) + Delta (paper, eq. 3), exact for u and Delta held over dt."""
    E = math.exp(-k * dt)
    g = (1 - E) / k
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    p = np.array([E, 0, 1 - E, dt - g])
    p_u = dt**2 / 2 - dt / k + g / k
    A = np.vstack([p, k * (setpoint[0] - p), setpoint])
    B = np.array([p_u, k * (input_[0] - p_u), *input_])
    return A, B, np.array([g, E, 0, 0])


def velocity_aware_axis(k: float, dt: float) -> AxisModel:
    """p' = v_d + k (p_d - p) + Delta, exact for u and Delta held over dt.

    The base of a flight controller that is told p_d, v_d and a_d.
    """
    E = math.exp(-k * dt)
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    p = setpoint[0] + np.array([E, 0, -E, 0])
    A = np.vstack([p, setpoint[1] + k * (setpoint[0] - p), setpoint])
    B = np.array([input_[0], input_[1], *input_])
    return A, B, np.array([(1 - E) / k, E, 0, 0])


def integral_axis(k: float, dt: float) -> AxisModel:
    """The baseline that believes the command: the base is where it was sent."""
    setpoint, input_ = np.array([[0, 0, 1, dt], [0, 0, 0, 1]]), np.array([dt**2 / 2, dt])
    return np.vstack([setpoint, setpoint]), np.array([*input_, *input_]), np.zeros(4)


AXIS_MODELS: dict[str, Callable[[float, float], AxisModel]] = {
    "paper": paper_axis,
    "exact": exact_axis,
    "velocity_aware": velocity_aware_axis,
    "integral": integral_axis,
}


@dataclass(frozen=True)
class EquivalentModel:
    """x+ = A x + B u + C Delta, and where each quantity stands in x.

    Attributes:
        A: (nx, nx), nx = 12 + 2 n.
        B: (nx, 3 + n).
        C: (nx, 3), the paper's C restricted to its non-zero columns.
        dt: s, period.
        k_b: (3,) 1/s, diagonal of K_B.
        believes_command: whether x_0 takes the base from the setpoint.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    dt: float
    k_b: np.ndarray
    believes_command: bool

    @classmethod
    def make(cls, kind: str, k_b: np.ndarray, dt: float, joints: int) -> EquivalentModel:
        """Assembles the model of three base axes and `joints` joints.

        Args:
            kind: A key of `AXIS_MODELS`.
            k_b: (3,) 1/s.
            dt: s.
            joints: n.
        """
        axes = [AXIS_MODELS[kind](k, dt) for k in k_b]
        A = block_diag(*(a for a, _, _ in axes), *[np.array([[1, dt], [0, 1]])] * joints)
        B = block_diag(*(b[:, None] for _, b, _ in axes), *[np.array([[dt**2 / 2], [dt]])] * joints)
        C = np.zeros((len(A), 3))
        C[: 3 * BASE_STATES] = block_diag(*(c[:, None] for _, _, c in axes))
        return cls(A, B, C, dt, np.asarray(k_b, dtype=float), kind == "integral")

    @cached_property
    def joints(self) -> int:
        """n."""
        return self.B.shape[1] - 3

    @cached_property
    def base_position(self) -> np.ndarray:
        """(3,) indices of p_B in x."""
        return BASE_STATES * np.arange(3)

    @cached_property
    def base_velocity(self) -> np.ndarray:
        """(3,) indices of p_B' in x."""
        return self.base_position + 1

    @cached_property
    def setpoint_position(self) -> np.ndarray:
        """(3,) indices of p_B,d in x."""
        return self.base_position + 2

    @cached_property
    def setpoint_velocity(self) -> np.ndarray:
        """(3,) indices of p_B,d' in x."""
        return self.base_position + 3

    @cached_property
    def joint_position(self) -> np.ndarray:
        """(n,) indices of q in x."""
        return 3 * BASE_STATES + 2 * np.arange(self.joints)

    @cached_property
    def joint_velocity(self) -> np.ndarray:
        """(n,) indices of q' in x."""
        return self.joint_position + 1

    def initial_state(
        self,
        p_B: np.ndarray,
        v_B: np.ndarray,
        base_setpoint: np.ndarray,
        joint_setpoint: np.ndarray,
    ) -> np.ndarray:
        """x_0 from measurement and command.

        The arm is where it is commanded (paper, section II-B), and so is the
        base of the integral model.

        Args:
            p_B: (3,) m, measured.
            v_B: (3,) m/s, measured.
            base_setpoint: (6+,) [p_d, v_d, ...] in m, m/s.
            joint_setpoint: (2 n+,) [q_d, q_d', ...] in rad, rad/s.
        """
        n = self.joints
        p_d, v_d = base_setpoint[:3], base_setpoint[3:6]
        x = np.empty(len(self.A))
        x[self.base_position] = p_d if self.believes_command else p_B
        x[self.base_velocity] = v_d if self.believes_command else v_B
        x[self.setpoint_position] = p_d
        x[self.setpoint_velocity] = v_d
        x[self.joint_position] = joint_setpoint[:n]
        x[self.joint_velocity] = joint_setpoint[n : 2 * n]
        return x

    def predict(self, x: np.ndarray, u: np.ndarray, delta: np.ndarray) -> np.ndarray:
        """(nx,) the state one period later, under u (3 + n,) and Delta (3,) m/s."""
        return self.A @ x + self.B @ u + self.C @ delta

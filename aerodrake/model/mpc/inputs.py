"""What one tick of the MPC, or of what stands in its place, is about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerodrake.model.vehicle.kinematics import EndEffector, ToolAxis


@dataclass(frozen=True)
class Pointing:
    """The orientation task at one tick.

    Attributes:
        axis: The tool's, at the measured state.
        reference: (N + 1, 6), its wanted direction d and d' [1/s], in the world, now
            and at each stage.
    """

    axis: ToolAxis
    reference: np.ndarray


@dataclass(frozen=True)
class MpcInputs:
    """What one tick is about.

    Attributes:
        x_0: (nx,) state of the equivalent model.
        u_last: (3 + n,) m/s^2 and rad/s^2, the input until now.
        end_effector: Kinematics at the measured state.
        rpy_rates: (3,) rad/s, measured rates of roll, pitch (the paper's xi_u) and yaw.
        reference: (N + 1, 6), p_Ed [m] and p_Ed' [m/s] now and at each stage.
        delta: (3,) m/s, residual velocity.
        w_q, w_m, w_d: From the weight allocator.
        pointing: None where the tool may point where it likes.
    """

    x_0: np.ndarray
    u_last: np.ndarray
    end_effector: EndEffector
    rpy_rates: np.ndarray
    reference: np.ndarray
    delta: np.ndarray
    w_q: float
    w_m: float
    w_d: float
    pointing: Pointing | None = None

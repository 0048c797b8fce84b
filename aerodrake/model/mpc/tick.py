"""Inputs and status of one tick of the MPC, or of a controller in its place."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.kinematics import EndEffector, ToolAxis

MISSED = 8
"""Status of a tick that solved no program; the smaller numbers are those of `QpStatus`."""


class TickStatus(NamedTuple):
    """Status of the last tick, as controllers report it.

    Attributes:
        status: A `QpStatus`, or `MISSED`.
        iterations: Iterations of the solver; 0 if none was called.
        ticks_since_solved: 0 if this tick solved its program.
    """

    status: float
    iterations: float
    ticks_since_solved: float


@dataclass(frozen=True)
class Pointing:
    """Inputs of the orientation task at one tick.

    Attributes:
        axis: The tool's axis at the measured state.
        reference: (N + 1, 6), its desired direction d and d' [1/s], in the world, now
            and at each stage.
    """

    axis: ToolAxis
    reference: np.ndarray


@dataclass(frozen=True)
class MpcInputs:
    """Measurements, reference and weights at one tick.

    Attributes:
        x_0: (nx,) state of the equivalent model.
        u_last: (3 + n,) m/s^2 and rad/s^2, the input until now.
        end_effector: Kinematics at the measured state.
        rpy_rates: (3,) rad/s, measured rates of roll, pitch (the paper's xi_u) and yaw.
        reference: (N + 1, 6), p_Ed [m] and p_Ed' [m/s] now and at each stage.
        delta: (3,) Delta, in the unit of the model's residual.
        w_q, w_m, w_d: Factors from the weight allocator.
        pointing: The orientation task; None without one.
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

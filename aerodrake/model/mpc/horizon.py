"""Stages of the MPC's horizon, and the outputs of the model at each of them."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from scipy.optimize import brentq

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.scenario import Mpc


def stage_ticks(config: Mpc) -> np.ndarray:
    """Returns (N,), the number of ticks that each stage lasts.

    The first stage lasts one tick. Durations grow geometrically, rounded to ticks, so that
    `config.horizon` stages last `config.span_ticks` in all. With as many stages as ticks, or
    more, each stage lasts one tick.
    """
    N, span = config.horizon, config.span_ticks
    if span <= N:
        return np.ones(N, dtype=int)
    powers = np.arange(N)
    ratio = brentq(lambda growth: np.sum(growth**powers) - span, 1.0, span ** (1 / (N - 1)))
    ends = np.round(np.cumsum(ratio**powers)).astype(int)
    ends = np.maximum.accumulate(np.maximum(ends, powers + 1))
    return np.sort(np.diff(ends, prepend=0))


def stage_times(config: Mpc, period: float) -> np.ndarray:
    """Returns (N + 1,) s: 0 and the end of each stage, for ticks of `period` s."""
    return period * np.append(0, np.cumsum(stage_ticks(config)))


class StageTransition(NamedTuple):
    """x_k = A x_{k-1} + B u_{k-1} + C Delta over one stage, in which u and Delta are constant.

    Attributes:
        A: (nx, nx).
        B: (nx, m), m = 3 + n.
        C: (nx, 3).
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray

    @classmethod
    def of(cls, model: EquivalentModel, ticks: int) -> Self:
        """Returns the transition over so many periods of the model."""
        A, (B, C) = np.eye(len(model.A)), (np.zeros_like(x) for x in (model.B, model.C))
        for _ in range(ticks):
            A, B, C = model.A @ A, model.A @ B + model.B, model.A @ C + model.C
        return cls(A, B, C)


class OutputMap(NamedTuple):
    """y_k = now x_k + before x_{k-1} + first x_0, the outputs at the end of one stage.

    y = [p_B', q', p_B, q, a, a'] has F = 2 m + 6 entries, m = 3 + n. a is the acceleration of
    the base, which tilts it. p_B, q and a are relative to x_0; a' is the mean rate of a over the
    stage.

    Attributes:
        now, before, first: (F, nx).
    """

    now: np.ndarray
    before: np.ndarray
    first: np.ndarray

    @classmethod
    def of(cls, model: EquivalentModel, stage_s: float) -> Self:
        """Returns the map for a stage that lasts `stage_s` s."""
        identity, a = np.eye(len(model.A)), model.acceleration
        velocity = identity[np.concatenate([model.base_velocity, model.joint_velocity])]
        position = identity[np.concatenate([model.base_position, model.joint_position])]
        zero = np.zeros_like(velocity)
        return cls(
            now=np.vstack([velocity, position, a, a / stage_s]),
            before=np.vstack([zero, zero, 0 * a, -a / stage_s]),
            first=np.vstack([zero, -position, -a, 0 * a]),
        )


class OutputSlices(NamedTuple):
    """Parts of y that belong together: p_B, q and a, or their rates."""

    base: slice
    joint: slice
    tilt: slice


def output_slices(joints: int) -> tuple[OutputSlices, OutputSlices]:
    """Returns the parts (p_B, q, a) and (p_B', q', a') of the y of `OutputMap`, for n `joints`."""
    ends = np.cumsum([0, 3, joints, 3, joints, 3, 3]).tolist()
    v_B, v_q, p_B, q, a, a_rate = (slice(start, end) for start, end in pairwise(ends))
    return OutputSlices(p_B, q, a), OutputSlices(v_B, v_q, a_rate)


class StageResponses:
    """Responses of the states and outputs of all stages to x_0, Delta and the inputs.

    x_k = Phi_k x_0 + Psi_k Delta + Gamma_k U, where U stacks u_0 ... u_{N-1}. Each axis of base
    and arm has its own input in the model, so that each output depends on the inputs of one axis,

        y_f = free_f [x_0, Delta] + G_f z_axis(f),

    where z (m N,) stacks the scaled inputs axis by axis, the stages of the first axis first.

    Attributes:
        Phi: (N, nx, nx).
        Psi: (N, nx, 3), for constant Delta.
        Gamma: (N, nx, N m).
        free: (F, N, nx + 3).
        G: (F, N, N), [output, stage, input].
        axis: (F,), the axis of each output.

    Args:
        model: The equivalent model.
        ticks: (N,), periods of the model that each stage lasts.
        scale: (m,), inputs per unit of z.
    """

    def __init__(self, model: EquivalentModel, ticks: Sequence[int], scale: np.ndarray):
        (nx, m), N = model.B.shape, len(ticks)
        Phi, Psi, Gamma = [np.eye(nx)], [np.zeros((nx, 3))], [np.zeros((nx, N * m))]
        free, by_input = [], []
        for k, stage in enumerate(ticks):
            A, B, C = StageTransition.of(model, stage)
            Phi.append(A @ Phi[k])
            Psi.append(A @ Psi[k] + C)
            Gamma.append(A @ Gamma[k])
            Gamma[k + 1][:, k * m : (k + 1) * m] += B
            now, before, first = OutputMap.of(model, model.dt * stage)
            by_x_0 = now @ Phi[k + 1] + before @ Phi[k] + first
            free.append(np.hstack([by_x_0, now @ Psi[k + 1] + before @ Psi[k]]))
            by_input.append(now @ Gamma[k + 1] + before @ Gamma[k])
        self.Phi, self.Psi, self.Gamma = (np.array(x[1:]) for x in (Phi, Psi, Gamma))
        self.free = np.stack(free, axis=1)
        self.axis = np.concatenate([np.arange(m), np.arange(m), np.arange(3), np.arange(3)])
        by_axis = np.stack(by_input, axis=1).reshape(-1, N, N, m)
        self.G = np.array([by_axis[f, :, :, a] * scale[a] for f, a in enumerate(self.axis)])

"""Stages of the MPC's horizon, and the outputs of the model at each of them."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.scenario import Mpc

IDENTICAL = 1e-12
"""Largest difference of two responses that count as one, relative to their largest element."""


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


class StageStates:
    """States x_k = Phi_k x_0 + Gamma_k U + Psi_k Delta of the model at the end of stage k.

    U stacks u_0 ... u_{N-1}. Stage k = 1 ... N lasts `stage_ticks[k - 1]` ticks with constant
    input u_{k-1}.

    Attributes:
        Phi: (N, nx, nx).
        Gamma: (N, nx, N m), m = 3 + n.
        Psi: (N, nx, 3), for constant Delta.

    Args:
        model: The equivalent model.
        stage_ticks: (N,), periods of the model that each stage lasts.
    """

    def __init__(self, model: EquivalentModel, stage_ticks: Sequence[int]):
        nx, m = model.B.shape
        horizon = len(stage_ticks)
        self.Phi = np.empty((horizon, nx, nx))
        self.Gamma = np.zeros((horizon, nx, horizon * m))
        self.Psi = np.empty((horizon, nx, 3))
        Phi, Gamma, Psi = np.eye(nx), np.zeros((nx, horizon * m)), np.zeros((nx, 3))
        for k, ticks in enumerate(stage_ticks):
            for _ in range(ticks):
                Phi, Gamma, Psi = model.A @ Phi, model.A @ Gamma, model.A @ Psi + model.C
                Gamma[:, k * m : (k + 1) * m] += model.B
            self.Phi[k], self.Gamma[k], self.Psi[k] = Phi, Gamma, Psi


class StageOutputs:
    """y = [p_B', q', p_B, q, a, a'] at the end of each stage, F = 2 (3 + n) + 6 numbers.

    a is the acceleration of the base, which tilts it. p_B, q and a are relative to x_0; a' is
    the mean rate of a over the stage. The axes of base and arm are decoupled in the model, so
    each output depends on the inputs of one axis,

        y_f = G_f z_axis(f) + [free response to x_0 and Delta],

    where z (m N,) stacks the scaled inputs axis by axis. Outputs with identical dynamics, as
    those of identical joints, share their G.

    Attributes:
        axis: (F,), the axis of each output.
        kind: (F,), index of each output's response in `responses`.
        responses: (K, N, N), the distinct G: [stage, input].
        free_response: (F, N, nx + 3), per [x_0, Delta].

    Args:
        model: The equivalent model.
        states: States of the model at the stages.
        stage_s: (N,) s, duration of each stage.
        scale: (m,), inputs per unit of z.
    """

    def __init__(
        self, model: EquivalentModel, states: StageStates, stage_s: np.ndarray, scale: np.ndarray
    ):
        N, m = len(stage_s), len(scale)
        self.axis = np.concatenate([np.arange(m), np.arange(m), np.arange(3), np.arange(3)])
        velocity = np.concatenate([model.base_velocity, model.joint_velocity])
        position = np.concatenate([model.base_position, model.joint_position])

        def outputs(x: np.ndarray, x_0: np.ndarray) -> np.ndarray:
            """Returns y (F, N, ...) for states x (N, nx, ...) that start at x_0 (nx, ...)."""
            a = np.tensordot(x, model.acceleration, (1, 1))
            a = np.moveaxis(a, -1, 1)
            a_0 = np.tensordot(model.acceleration, x_0, 1)
            steps = np.diff(a, axis=0, prepend=a_0[None])
            rate = steps / stage_s.reshape(-1, *[1] * (steps.ndim - 1))
            parts = [x[:, velocity], x[:, position] - x_0[position], a - a_0, rate]
            return np.moveaxis(np.concatenate(parts, axis=1), 0, 1)

        nx = len(model.A)
        by_x_0 = outputs(states.Phi, np.eye(nx))
        by_delta = outputs(states.Psi, np.zeros((nx, 3)))
        self.free_response = np.concatenate([by_x_0, by_delta], axis=2)
        by_u = outputs(states.Gamma, np.zeros((nx, N * m))).reshape(-1, N, N, m)
        G = np.array([by_u[f, :, :, axis] * scale[axis] for f, axis in enumerate(self.axis)])
        largest = np.abs(G).max(axis=(1, 2))
        is_identical = np.abs(G[:, None] - G).max(axis=(2, 3)) <= IDENTICAL * largest
        first, self.kind = np.unique(is_identical.argmax(axis=1), return_inverse=True)
        self.responses = G[first]

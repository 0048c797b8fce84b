"""The equivalent model over the horizon, with the states eliminated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel


class Prediction:
    """x_k = Phi_k x_0 + Gamma_k U + Psi_k Delta for k = 1 ... N.

    U stacks u_0 ... u_{N-1}. The model is constant, so these are computed once.

    Stage k ends `stage_ticks[k - 1]` ticks after the one before; u_{k-1} is held so
    long, and x_k is the state at its end.

    Attributes:
        Phi: (N, nx, nx).
        Gamma: (N, nx, N m), m = 3 + n.
        Psi: (N, nx, 3), for Delta held over the horizon.

    Args:
        model: The equivalent model.
        stage_ticks: (N,) how many periods of the model each stage lasts.
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

    def free(self, x_0: np.ndarray, delta: np.ndarray) -> np.ndarray:
        """(N, nx), the states from x_0 (nx,) under `delta` (3,) m/s, if all inputs are zero."""
        return self.Phi @ x_0 + self.Psi @ delta

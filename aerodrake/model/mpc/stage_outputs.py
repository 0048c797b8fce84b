"""What the MPC's cost sees of each stage of the horizon, as functions of x_0, Delta and inputs."""

from __future__ import annotations

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.prediction import Prediction

ALIKE = 1e-12
"""By how much responses that count as one may differ, in parts of their largest element."""


class StageOutputs:
    """y = [p_B', q', p_B, q, a, a'] at the end of each stage, F = 2 (3 + n) + 6 numbers.

    Places p_B, q and the acceleration a of the base, which tilts it, are by how much
    they are off those of x_0; a' is how fast a changes on the way to the stage. Axes of
    base and arm do not meet in the model: an output is moved by the inputs of one axis,

        y_f = G_f z_axis(f) + [free response to x_0 and Delta],

    z (m N,) being the scaled inputs, all stages of the first axis first. Outputs
    that answer alike, as those of equal joints do, share their G.

    Attributes:
        axis: (F,) the axis of each output.
        kind: (F,) which of the `responses` each output has.
        responses: (K, N, N), G of every kind: [stage, input].
        free: (F, N, nx + 3), per [x_0, Delta].

    Args:
        model: The equivalent model.
        prediction: Of the model, over the stages.
        stage_s: (N,) s, how long each stage lasts.
        scale: (m,) inputs per unit of z.
    """

    def __init__(
        self,
        model: EquivalentModel,
        prediction: Prediction,
        stage_s: np.ndarray,
        scale: np.ndarray,
    ):
        N, m = len(stage_s), len(scale)
        self.axis = np.concatenate([np.arange(m), np.arange(m), np.arange(3), np.arange(3)])
        velocity = np.concatenate([model.base_velocity, model.joint_velocity])
        position = np.concatenate([model.base_position, model.joint_position])

        def outputs(x: np.ndarray, x_0: np.ndarray) -> np.ndarray:
            """(F, N, ...) from states (N, nx, ...) that x_0 (nx, ...) led to."""
            a = np.tensordot(x, model.acceleration, (1, 1))
            a = np.moveaxis(a, -1, 1)
            a_0 = np.tensordot(model.acceleration, x_0, 1)
            steps = np.diff(a, axis=0, prepend=a_0[None])
            swing = steps / stage_s.reshape(-1, *[1] * (steps.ndim - 1))
            parts = [x[:, velocity], x[:, position] - x_0[position], a - a_0, swing]
            return np.moveaxis(np.concatenate(parts, axis=1), 0, 1)

        nx = len(model.A)
        by_x_0 = outputs(prediction.Phi, np.eye(nx))
        by_delta = outputs(prediction.Psi, np.zeros((nx, 3)))
        self.free = np.concatenate([by_x_0, by_delta], axis=2)
        by_u = outputs(prediction.Gamma, np.zeros((nx, N * m))).reshape(-1, N, N, m)
        G = np.array([by_u[f, :, :, axis] * scale[axis] for f, axis in enumerate(self.axis)])
        # Alike but for how their products were rounded.
        alike = np.abs(G[:, None] - G).max(axis=(2, 3)) <= ALIKE * np.abs(G).max(axis=(1, 2))
        first, self.kind = np.unique(alike.argmax(axis=1), return_inverse=True)
        self.responses = G[first]

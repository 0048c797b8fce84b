"""Condensing: from a quadratic cost of stage outputs to a quadratic program in the inputs."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.mpc.horizon import StageResponses
from aerodrake.model.mpc.objective import StageCost
from aerodrake.support.compiled import compiled

IDENTICAL = 1e-12
"""Largest difference of two responses that count as one, relative to their largest element."""


class Condensing(NamedTuple):
    """Constant part of the programs.

    Outputs with identical dynamics, as those of identical joints, share their response.

    Attributes:
        axis: (F,), the axis of each output.
        kind: (F,), index of each output's response.
        responses: (F, N, N), response G of each output, [stage, input].
        ticks: (N,), duration of each stage.
        products: (K, K, N, N), G^T D G of each pair of the K distinct responses, D = diag(ticks).
        H_input: (m, N, N), cost of the inputs of each axis.
    """

    axis: np.ndarray
    kind: np.ndarray
    responses: np.ndarray
    ticks: np.ndarray
    products: np.ndarray
    H_input: np.ndarray

    @classmethod
    def make(cls, responses: StageResponses, ticks: np.ndarray, H_input: np.ndarray) -> Self:
        """Computes the products for stages of `ticks` (N,) and H_input (m, N, N)."""
        G = responses.G
        largest = np.abs(G).max(axis=(1, 2))
        is_identical = np.abs(G[:, None] - G).max(axis=(2, 3)) <= IDENTICAL * largest
        first, kind = np.unique(is_identical.argmax(axis=1), return_inverse=True)
        products = np.einsum("fki,k,gkj->fgij", G[first], ticks, G[first], optimize=True)
        return cls(responses.axis, kind, G, ticks, np.ascontiguousarray(products), H_input)


@compiled
def hessian(form: Condensing, C: np.ndarray) -> np.ndarray:
    """Returns H (m N, m N), where z^T H z / 2 + g^T z is half the cost up to a constant.

    The cost is the sum over stages of ticks (y^T C y + 2 c_k^T y), plus that of the inputs.
    The block of axes a and b is H_ab, the sum of C_fg G_f^T D G_g over outputs f of a, g of b.

    Args:
        form: Constant part of the program.
        C: (F, F), symmetric.
    """
    m, N, _ = form.H_input.shape
    H = np.zeros((m * N, m * N))
    for a in range(m):
        H[a * N : (a + 1) * N, a * N : (a + 1) * N] = form.H_input[a]
    for f in range(len(form.axis)):
        for g in range(len(form.axis)):
            a, b, c = form.axis[f], form.axis[g], C[f, g]
            if a <= b and c != 0:
                product = form.products[form.kind[f], form.kind[g]]
                for i in range(N):
                    for j in range(N):
                        H[a * N + i, b * N + j] += c * product[i, j]
    for i in range(m * N):
        for j in range(i):
            H[i, j] = H[j, i]
    return H


def gradient(form: Condensing, cost: StageCost, free: np.ndarray) -> np.ndarray:
    """Returns g (m N,) of the program whose H `hessian` returns.

    Args:
        form: Constant part of the program.
        cost: Cost of the outputs y.
        free: (F, N), y with zero inputs.
    """
    m = len(form.H_input)
    slope = form.ticks * (cost.C @ free + cost.c)
    by_output = (slope[:, None] @ form.responses)[:, 0]
    g = by_output[:m] + by_output[m : 2 * m]  # Outputs are velocities, positions, a and a'.
    g[:3] += by_output[2 * m : 2 * m + 3] + by_output[2 * m + 3 :]
    return g.ravel()


def outputs_under(form: Condensing, free: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Returns the outputs y (F, N) under the inputs z (m N,).

    Args:
        form: Constant part of the program.
        free: (F, N), y with zero inputs.
        z: (m N,), scaled inputs.
    """
    by_axis = z.reshape(len(form.H_input), -1)
    return free + (form.responses @ by_axis[form.axis, :, None])[..., 0]


def rows_by_input(form: Condensing, rows: np.ndarray) -> np.ndarray:
    """Returns L (N, d, m N), where rows y_k = L_k z if x_0 and Delta are zero.

    Args:
        form: Constant part of the program.
        rows: (d, F).
    """
    m, N, _ = form.H_input.shape
    L = np.zeros((N, len(rows), m, N))
    for f, axis in enumerate(form.axis):
        L[:, :, axis] += rows[:, f, None] * form.responses[f][:, None]
    return L.reshape(N, len(rows), m * N)

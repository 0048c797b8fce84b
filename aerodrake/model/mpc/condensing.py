"""Condensing: from a quadratic cost on stage outputs to a quadratic program in the inputs."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.mpc.horizon import StageOutputs
from aerodrake.model.mpc.stage_cost import StageCost
from aerodrake.support.compiled import compiled

MAX_OUTPUTS = 4
"""Largest number of outputs that one axis drives: those of the base."""


class Condensing(NamedTuple):
    """Constant part of the programs.

    Attributes:
        axis: (F,), the axis of each output.
        output_index: (m, 4), outputs driven by each axis, padded by repetition.
        output_count: (m,), number of entries that are not padding: 4 of the base's axes, 2 of
            the joints'.
        kind: (F,), index of each output's response.
        responses: (K, N, N), the distinct responses G.
        ticks: (N,), duration of each stage.
        products: (K, K, N, N), G^T D G of each pair of responses, with D = diag(ticks).
        H_input: (m, N, N), cost of the inputs of each axis.
    """

    axis: np.ndarray
    output_index: np.ndarray
    output_count: np.ndarray
    kind: np.ndarray
    responses: np.ndarray
    ticks: np.ndarray
    products: np.ndarray
    H_input: np.ndarray

    @classmethod
    def make(cls, outputs: StageOutputs, ticks: np.ndarray, H_input: np.ndarray) -> Self:
        """Computes the products for stages of `ticks` (N,) and H_input (m, N, N)."""
        G, ticks = outputs.responses, ticks.astype(float)
        products = np.einsum("fki,k,gkj->fgij", G, ticks, G, optimize=True)
        by_axis = [np.flatnonzero(outputs.axis == a) for a in range(len(H_input))]
        return cls(
            axis=outputs.axis,
            output_index=np.array([np.resize(indices, MAX_OUTPUTS) for indices in by_axis]),
            output_count=np.array([len(indices) for indices in by_axis]),
            kind=outputs.kind,
            responses=G,
            ticks=ticks,
            products=np.ascontiguousarray(products),
            H_input=H_input,
        )


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
    NN, K = N * N, len(form.products)
    products = form.products.reshape(K * K, NN)
    H, block = np.empty((m * N, m * N)), np.empty(NN)
    max_pairs = form.output_index.shape[1] ** 2
    C_fg, pair = np.empty(max_pairs), np.empty(max_pairs, dtype=np.int64)
    for a in range(m):
        for b in range(a, m):
            pairs = 0
            for f in form.output_index[a, : form.output_count[a]]:
                for g in form.output_index[b, : form.output_count[b]]:
                    C_fg[pairs] = C[f, g]
                    pair[pairs] = form.kind[f] * K + form.kind[g]
                    pairs += 1
            assert pairs % 4 == 0  # Axes have 2 or 4 outputs.
            own = form.H_input[a].reshape(NN)
            for i in range(NN):
                block[i] = own[i] if a == b else 0.0
            for k in range(0, pairs, 4):  # Four pairs at a time make fewer passes over the block.
                c_0, c_1, c_2, c_3 = C_fg[k], C_fg[k + 1], C_fg[k + 2], C_fg[k + 3]
                M_0, M_1 = products[pair[k]], products[pair[k + 1]]
                M_2, M_3 = products[pair[k + 2]], products[pair[k + 3]]
                for i in range(NN):
                    block[i] += c_0 * M_0[i] + c_1 * M_1[i] + c_2 * M_2[i] + c_3 * M_3[i]
            for i in range(N):
                for j in range(N):
                    H[a * N + i, b * N + j] = block[i * N + j]
            if a < b:
                for j in range(N):
                    for i in range(N):
                        H[b * N + j, a * N + i] = block[i * N + j]
    return H


@compiled
def gradient(form: Condensing, cost: StageCost, free_response: np.ndarray) -> np.ndarray:
    """Returns g (m N,) of the program whose H `hessian` returns.

    Args:
        form: Constant part of the program.
        cost: Cost of the outputs y.
        free_response: (F, N), y with zero inputs.
    """
    slope = cost.C @ free_response + cost.c
    m, N, _ = form.H_input.shape
    g = np.zeros(m * N)
    for f in range(len(form.axis)):
        a, G = form.axis[f], form.responses[form.kind[f]]
        for k in range(N):
            weighted = form.ticks[k] * slope[f, k]
            for j in range(k + 1):
                g[a * N + j] += G[k, j] * weighted
    return g


@compiled
def outputs_under(form: Condensing, free_response: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Returns the outputs y (F, N) under the inputs z (m N,).

    Args:
        form: Constant part of the program.
        free_response: (F, N), y with zero inputs.
        z: (m N,), scaled inputs.
    """
    N = free_response.shape[1]
    y = free_response.copy()
    for f in range(len(form.axis)):
        a, G = form.axis[f], form.responses[form.kind[f]]
        for k in range(N):
            for j in range(k + 1):
                y[f, k] += G[k, j] * z[a * N + j]
    return y

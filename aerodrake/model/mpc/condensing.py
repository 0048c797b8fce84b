"""From a quadratic cost on the outputs of the stages to a quadratic program in the inputs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.mpc.stage_outputs import StageOutputs
from aerodrake.support.compiled import compiled


class Condensing(NamedTuple):
    """What of the program is the same at every tick.

    Attributes:
        axis: (F,) the axis of each output.
        outputs: (m, 4) those of each axis; of joints, which have two, each twice.
        answers: (m,) how many those are.
        kind: (F,) its kind of response.
        responses: (K, N, N), G of each kind.
        ticks: (N,) how many each stage lasts.
        products: (K, K, N, N), G' D G of each pair of kinds, D the ticks of the stages.
        H_input: (m, N, N), the cost of inputs by axis.
    """

    axis: np.ndarray
    outputs: np.ndarray
    answers: np.ndarray
    kind: np.ndarray
    responses: np.ndarray
    ticks: np.ndarray
    products: np.ndarray
    H_input: np.ndarray

    @classmethod
    def make(cls, outputs: StageOutputs, ticks: np.ndarray, H_input: np.ndarray) -> Condensing:
        """For stages that last `ticks` (N,), and H_input (m, N, N), the cost of inputs."""
        G, ticks = outputs.responses, ticks.astype(float)
        products = np.einsum("fki,k,gkj->fgij", G, ticks, G, optimize=True)
        of_axis = [np.flatnonzero(outputs.axis == a) for a in range(len(H_input))]
        return cls(
            outputs.axis,
            np.array([np.resize(places, 4) for places in of_axis]),
            np.array([len(places) for places in of_axis]),
            outputs.kind,
            G,
            ticks,
            np.ascontiguousarray(products),
            H_input,
        )


@compiled
def hessian(form: Condensing, C: np.ndarray) -> np.ndarray:
    """(m N, m N), H: z' H z / 2 + g' z is half the cost, but for what z leaves alone.

    Block by block of two axes, H_ab = sum of C_fg G_f' D G_g over the outputs f of a and g of b:
    what the stages add up to is in `products` already.

    Args:
        form: What is the same at every tick.
        C: (F, F), symmetric: the cost is the sum over the stages of ticks (y' C y + 2 c_k' y),
            and that of the inputs.
    """
    m, N, _ = form.H_input.shape
    NN, K = N * N, len(form.products)
    products = form.products.reshape(K * K, NN)
    H, block = np.empty((m * N, m * N)), np.empty(NN)
    C_fg, pair = np.empty(16), np.empty(16, dtype=np.int64)
    for a in range(m):
        for b in range(a, m):
            pairs = 0
            for f in form.outputs[a, : form.answers[a]]:
                for g in form.outputs[b, : form.answers[b]]:
                    C_fg[pairs] = C[f, g]
                    pair[pairs] = form.kind[f] * K + form.kind[g]
                    pairs += 1
            own = form.H_input[a].reshape(NN)
            for i in range(NN):
                block[i] = own[i] if a == b else 0.0
            for k in range(0, pairs, 4):  # Four at a time are fewer passes over the block.
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
def gradient(form: Condensing, C: np.ndarray, c: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(m N,), g of the same.

    Args:
        form, C: As for `hessian`.
        c: (F, N).
        free: (F, N), y without inputs.
    """
    slope = C @ free + c
    m, N, _ = form.H_input.shape
    g = np.zeros(m * N)
    for f in range(len(form.axis)):
        a, G = form.axis[f], form.responses[form.kind[f]]
        for k in range(N):
            pull = form.ticks[k] * slope[f, k]
            for j in range(k + 1):
                g[a * N + j] += G[k, j] * pull
    return g


@compiled
def driven(form: Condensing, free: np.ndarray, z: np.ndarray) -> np.ndarray:
    """(F, N), y under the inputs z (m N,), from `free` (F, N), y without."""
    N = free.shape[1]
    y = free.copy()
    for f in range(len(form.axis)):
        a, G = form.axis[f], form.responses[form.kind[f]]
        for k in range(N):
            for j in range(k + 1):
                y[f, k] += G[k, j] * z[a * N + j]
    return y

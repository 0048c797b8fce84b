"""Rows whose elements stand side by side, as bounds on one axis of many do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.support.compiled import compiled


class BandedRows(NamedTuple):
    """A matrix (rows, nz), without the zeros before and behind what each row has.

    Attributes:
        band: (rows, w), w the width of the widest.
        start: (rows,), in which column each begins.
    """

    band: np.ndarray
    start: np.ndarray

    @classmethod
    def of(cls, A: np.ndarray) -> BandedRows:
        """Of a matrix A (rows, nz)."""
        rows, nz = A.shape
        first = np.array([np.flatnonzero(row)[0] if row.any() else 0 for row in A], dtype=int)
        last = np.array([np.flatnonzero(row)[-1] if row.any() else 0 for row in A], dtype=int)
        width = (last - first).max(initial=-1) + 1
        start = np.minimum(first, nz - width)
        band = np.array([row[i : i + width] for row, i in zip(A, start, strict=True)])
        return cls(band.reshape(rows, width), start)


@compiled
def rows_dot(A: BandedRows, z: np.ndarray) -> np.ndarray:
    """(rows,), A z of z (nz,)."""
    found = np.empty(len(A.start))
    for i in range(len(found)):
        found[i] = row_dot(A, i, z)
    return found


@compiled
def row_dot(A: BandedRows, i: int, z: np.ndarray) -> float:
    """Row i times z (nz,)."""
    total, start = 0.0, A.start[i]
    for j in range(A.band.shape[1]):
        total += A.band[i, j] * z[start + j]
    return total

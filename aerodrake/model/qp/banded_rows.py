"""Banded storage of a matrix."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.support.compiled import compiled


class BandedRows(NamedTuple):
    """A matrix (rows, nz), stored without the zeros before and after the entries of each row.

    Attributes:
        band: (rows, w), w the width of the widest row.
        start: (rows,), first column of each row of `band`.
    """

    band: np.ndarray
    start: np.ndarray

    @classmethod
    def of(cls, A: np.ndarray) -> Self:
        """Converts a dense matrix A (rows, nz)."""
        rows, nz = A.shape
        first = np.array([np.flatnonzero(row)[0] if row.any() else 0 for row in A], dtype=int)
        last = np.array([np.flatnonzero(row)[-1] if row.any() else 0 for row in A], dtype=int)
        width = (last - first).max(initial=-1) + 1
        start = np.minimum(first, nz - width)
        band = np.array([row[i : i + width] for row, i in zip(A, start, strict=True)])
        return cls(band.reshape(rows, width), start)


@compiled
def rows_dot(A: BandedRows, z: np.ndarray) -> np.ndarray:
    """Returns A z (rows,) for z (nz,)."""
    products = np.empty(len(A.start))
    for i in range(len(products)):
        products[i] = row_dot(A, i, z)
    return products


@compiled
def row_dot(A: BandedRows, i: int, z: np.ndarray) -> float:
    """Returns the product of row i and z (nz,)."""
    total, start = 0.0, A.start[i]
    for j in range(A.band.shape[1]):
        total += A.band[i, j] * z[start + j]
    return total

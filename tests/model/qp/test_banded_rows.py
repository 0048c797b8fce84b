"""Banded rows against the dense matrix."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.qp.banded_rows import BandedRows, row_dot, rows_dot


@given(st.integers(0, 6), st.integers(1, 8), st.integers(0, 2**31))
def test_products_equal_those_of_the_dense_matrix(rows, nz, seed):
    rng = np.random.default_rng(seed)
    A = np.zeros((rows, nz))
    for row in A:  # Of any width, some empty, some with zeros inside.
        first, last = sorted(rng.integers(0, nz + 1, 2))
        row[first:last] = rng.normal(size=last - first) * (rng.random(last - first) < 0.8)
    banded, z = BandedRows.of(A), rng.normal(size=nz)
    np.testing.assert_allclose(rows_dot(banded, z), A @ z, atol=1e-12)
    for i in range(rows):
        np.testing.assert_allclose(row_dot(banded, i, z), A[i] @ z, atol=1e-12)


def test_band_is_as_wide_as_the_widest_row():
    A = np.zeros((3, 9))
    A[0, 1:3], A[1, 8], A[2, 4:7] = 1, 2, 3
    banded = BandedRows.of(A)
    assert banded.band.shape == (3, 3)
    np.testing.assert_array_equal(banded.start, [1, 6, 4])

"""Tests of the diameter of a path."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from aerodrake.model.reference.reference_curve import farthest_pair, path_diameter


def test_path_diameter_finds_a_maximum_between_samples():
    def ellipse(s):
        return np.stack([2 * np.cos(s - 0.123), np.sin(s - 0.123), 0 * s], axis=-1)

    assert path_diameter(ellipse, np.linspace(0, 2 * np.pi, 50)) == pytest.approx(4, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 400), st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_farthest_pair_agrees_with_all_pairs(count, flat_axes, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points[:, :flat_axes] = 1.0
    i, j = farthest_pair(points)
    largest = max(pdist(points), default=0.0)
    assert np.linalg.norm(points[i] - points[j]) == pytest.approx(largest, abs=1e-12)

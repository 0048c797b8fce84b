"""Fixtures of tests of plants with mismatch or payload."""

import numpy as np
import pytest
from pydrake.geometry import SceneGraph


@pytest.fixture(scope="module")
def scene_graph() -> SceneGraph:
    return SceneGraph()


@pytest.fixture(scope="module")
def bent_state(vehicle) -> np.ndarray:
    """State at rest, tilted, with a bent arm."""
    state = vehicle.trim_state
    quaternion = np.array([0.9, 0.2, -0.3, 0.1])
    state[:4] = quaternion / np.linalg.norm(quaternion)
    state[7:13] += [0.3, -0.2, 0.1, 0.5, 0.2, -0.4]
    return state

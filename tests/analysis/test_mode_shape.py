"""Shapes of modes whose eigenvectors are known."""

import numpy as np
import pytest

from aerodrake.analysis.mode_shape import ModeShape, eigenvector
from tests.analyses import mode, point


def test_the_eigenvector_of_an_oscillation_is_its_motion_and_rate():
    hover = point(-2.0)
    vector = eigenvector(hover.system, hover.modes[0].eigenvalue)
    expected = [1, complex(-2.0, 2 * np.pi * 9.6), 0, 0, 0, 0]
    assert vector / vector[0] == pytest.approx(np.array(expected))


def test_the_shape_moves_the_tool_by_one_metre():
    """The tool's y is 0.3 m per rad of roll, its x that of the base."""
    hover = point(-2.0)
    roll = ModeShape.of(hover.system, hover.modes[0])
    assert roll.angles == pytest.approx({"roll": 1 / 0.3, "joint_2": 0}, abs=1e-9)
    assert roll.lengths == pytest.approx({"x": 0, "tool_x": 0, "tool_y": 1, "tool_z": 0}, abs=1e-9)
    x = ModeShape.of(hover.system, hover.modes[1])
    assert x.lengths == pytest.approx({"x": 1, "tool_x": 1, "tool_y": 0, "tool_z": 0}, abs=1e-9)


def test_a_mode_that_does_not_move_the_tool_has_no_shape():
    shape = ModeShape.of(point(-2.0).system, mode(-10.0, 0.0))
    assert {*shape.lengths.values(), *shape.angles.values()} == {0}

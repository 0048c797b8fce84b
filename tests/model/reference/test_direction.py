"""Tests of directions over time, and of files of directions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.reference.direction import check_start, make_direction
from aerodrake.scenario import AxisAlong, FixedAxis, OrientationOff
from aerodrake.support.errors import BadInput

HEADER = "t,ax,ay,az\n"


@pytest.fixture
def path(tmp_path):
    def along(content: str):
        (tmp_path / "d.csv").write_text(content)
        return make_direction(AxisAlong(file=str(tmp_path / "d.csv")))

    return along


def angles(rows: np.ndarray) -> np.ndarray:
    """Returns the angles (M - 1,) in rad between consecutive unit vectors."""
    return np.arccos(np.clip(np.sum(rows[1:] * rows[:-1], axis=1), -1, 1))


def test_off_returns_none():
    assert make_direction(OrientationOff()) is None


def test_a_fixed_direction_is_scaled_to_length_one():
    d, rate = make_direction(FixedAxis(axis=(0.0, 3.0, -4.0))).evaluate(np.array([-1.0, 0.0, 9.0]))
    np.testing.assert_allclose(d, np.tile([0, 0.6, -0.8], (3, 1)))
    assert not rate.any()


def test_the_default_is_down():
    np.testing.assert_array_equal(
        make_direction(FixedAxis()).evaluate(np.zeros(1))[0], [[0.0, 0.0, -1.0]]
    )


vectors = st.tuples(*[st.floats(-2, 2)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
tables = st.lists(st.tuples(st.floats(0.2, 3), vectors), min_size=2, max_size=6)


@given(tables)
def test_a_path_consists_of_unit_vectors_and_their_derivatives(tmp_path_factory, rows):
    steps, table = zip(*rows, strict=True)
    times, table = np.cumsum(steps), np.array(table)
    unit = table / np.linalg.norm(table, axis=1, keepdims=True)
    file = tmp_path_factory.getbasetemp() / "d.csv"
    np.savetxt(
        file, np.column_stack([times, table]), "%.17g", ",", header="t,ax,ay,az", comments=""
    )
    config = AxisAlong(file=str(file))
    if (angles(unit) > np.pi / 2 + 1e-5).any():
        with pytest.raises(BadInput, match="turns of 90 deg"):
            make_direction(config)
        return
    direction = make_direction(config)
    np.testing.assert_allclose(direction.evaluate(times)[0], unit, atol=1e-9)
    for t in (-1.0, 0.0, times[0] - 0.1):
        np.testing.assert_allclose(direction.evaluate(np.array([t]))[0], unit[:1], atol=1e-9)
    t = np.linspace(times[0], times[-1] + 1, 101)[1:]
    h = 1e-5
    d, rate = direction.evaluate(t)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.sum(d * rate, axis=1), 0, atol=1e-9)
    slope = (direction.evaluate(t + h)[0] - direction.evaluate(t - h)[0]) / (2 * h)
    # Within h of a row, where the slope has a kink, both differ by the order of h.
    np.testing.assert_allclose(rate, slope, atol=1e-3 * (1 + np.abs(rate).max()))


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("t,x,y,z\n0,0,0,1\n1,0,0,1\n", "row 1: expected the header t,ax,ay,az"),
        (HEADER + "0,0,0,-1\n", "expected at least 2 rows"),
        (HEADER + "0,0,0,-1\n2.5,0,0,0\n3,0,0,-1\n", "t = 2.5 s: expected ax, ay, az of length"),
        (HEADER + "0,0,0,-1\n1,0,here,1\n", "row 3: expected ay"),
        (HEADER + "0,0,0,-1\n1,0,2000,1\n", "row 3: expected ay in [-1000, 1000] 1"),
        (HEADER + "0,1,0,0\n1,1,0,0\n2,-1,1,0\n", "after t = 1 s: expected turns of 90 deg"),
    ],
)
def test_a_bad_file_is_refused_with_its_name_and_the_expected_value(path, content, expected):
    with pytest.raises(BadInput) as raised:
        path(content)
    message = str(raised.value)
    assert "d.csv" in message and expected in message and "\n" not in message


def test_refuses_a_direction_opposite_to_the_tool(vehicle):
    np.testing.assert_allclose(vehicle.tool_axis, [0, 0, -1], atol=1e-12)
    check_start(make_direction(FixedAxis(axis=(1.0, 0.0, 0.5))), vehicle)
    for axis in ((0.0, 0.0, 1.0), (0.5, 0.0, 1.0)):
        with pytest.raises(BadInput, match="orientation: expected .* within 120 deg"):
            check_start(make_direction(FixedAxis(axis=axis)), vehicle)

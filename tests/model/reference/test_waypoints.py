"""Tests of waypoint files, valid and invalid, and of the path through them."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.waypoints import (
    MAX_FILE_BYTES,
    interpolate_waypoints,
    read_waypoints,
)
from aerodrake.scenario import Waypoints
from aerodrake.support.errors import BadInput

START = np.array([0.0, 0.2, 1.2])
PACKAGED = Path(__file__).parents[3] / "aerodrake" / "scenarios" / "waypoints.csv"
GOOD = b"t,x,y,z\n0,0,0.2,1.2\n2,0.1,0.2,1.2\n"

BAD = {
    "empty file": (b"", "header"),
    "header only": (b"t,x,y,z\n", "at least 2 rows"),
    "one row": (b"t,x,y,z\n0,0,0,1\n", "at least 2 rows"),
    "no header": (b"0,0,0,1\n1,0,0,1\n", "header"),
    "wrong names": (b"time,x,y,z\n0,0,0,1\n1,0,0,1\n", "header"),
    "wrong order": (b"x,y,z,t\n0,0,0,1\n1,0,0,1\n", "header"),
    "extra column": (b"t,x,y,z,yaw\n0,0,0,1,0\n1,0,0,1,0\n", "header"),
    "semicolons": (b"t;x;y;z\n0;0;0;1\n1;0;0;1\n", "header"),
    "word": (b"t,x,y,z\n0,0,0,1\n1,0,here,1\n", "row 3: expected y"),
    "blank cell": (b"t,x,y,z\n0,0,0,1\n1,0,,1\n", "row 3: expected y"),
    "nan": (b"t,x,y,z\n0,nan,0,1\n1,0,0,1\n", "row 2: expected x"),
    "inf": (b"t,x,y,z\n0,0,0,1\n\n1,0,0,-inf\n", "row 4: expected z"),
    "overflow": (b"t,x,y,z\n0,0,0,1\n1e999,0,0,1\n", "row 3: expected t"),
    "too far": (b"t,x,y,z\n0,0,0,1\n1,0,0,1001\n", "row 3: expected z in [-1000, 1000] m"),
    "negative time": (b"t,x,y,z\n-1,0,0,1\n1,0,0,1\n", "row 2: expected t in [0, 100000] s"),
    "short row": (b"t,x,y,z\n0,0,0,1\n1,0,0\n", "row 3: expected 4 cells, got 3"),
    "long row": (b"t,x,y,z\n0,0,0,1\n1,0,0,1,\n", "row 3: expected 4 cells, got 5"),
    "repeated time": (b"t,x,y,z\n0,0,0,1\n1,0,0,1\n1,0,0,1\n", "row 4: expected t to ascend"),
    "descending time": (b"t,x,y,z\n0,0,0,1\n2,0,0,1\n1,0,0,1\n", "row 4: expected t to ascend"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00\xff\xfe", "UTF-8"),
    "UTF-16": ("t,x,y,z\n0,0,0,1\n1,0,0,1\n".encode("utf-16"), "UTF-8"),
    "NUL": (b"t,x,y,z\n0,0,0,1\n1,0,0,\x00\n", ""),
    "endless cell": (b"t,x,y,z\n0,0,0," + b"1" * 200_000, "comma-separated"),
}


@pytest.fixture
def write(tmp_path):
    def write_file(content: bytes) -> Path:
        path = tmp_path / "path.csv"
        path.write_bytes(content)
        return path

    return write_file


@pytest.mark.parametrize(("content", "expected"), BAD.values(), ids=BAD)
def test_a_bad_file_is_refused_with_its_name_and_the_expected_value(write, content, expected):
    path = write(content)
    with pytest.raises(BadInput) as raised:
        read_waypoints(path)
    message = str(raised.value)
    assert str(path) in message and expected in message
    assert len(message.splitlines()) == 1 and len(message) < len(str(path)) + 150


def test_a_path_that_is_no_file_is_refused_with_its_name(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    for path in (tmp_path / "missing.csv", tmp_path, tmp_path / "fifo", tmp_path / ("x" * 300)):
        with pytest.raises(BadInput, match=path.name):
            read_waypoints(path)


def test_a_file_too_large_is_not_read(write):
    path = write(b"")
    os.truncate(path, MAX_FILE_BYTES + 1)
    with pytest.raises(BadInput, match="bytes"):
        read_waypoints(path)


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + GOOD,
        GOOD.replace(b"\n", b"\r\n"),
        GOOD.replace(b"t,x,y,z", b" T , X,Y ,Z"),
        GOOD.replace(b",", b" , "),
        GOOD.rstrip(),
        GOOD.replace(b"\n", b"\n\n"),
    ],
)
def test_variants_of_a_good_file(write, content):
    times, points = read_waypoints(write(content))
    np.testing.assert_array_equal(times, [0, 2])
    np.testing.assert_array_equal(points, START + [[0, 0, 0], [0.1, 0, 0]])


paths = st.lists(
    st.tuples(st.floats(0.1, 5), *[st.floats(-1, 1)] * 3), min_size=2, max_size=30
).map(np.array)


@settings(max_examples=50, deadline=None)
@given(paths)
def test_path_passes_its_points_without_overshoot_and_rests_at_both_ends(rows):
    times, points = np.cumsum(rows[:, 0]), rows[:, 1:]
    path = interpolate_waypoints(times, points)
    velocity = path.derivative()
    np.testing.assert_allclose(path.vector_values(times).T, points, atol=1e-9)
    np.testing.assert_allclose(velocity.vector_values(times[[0, -1]]), 0, atol=1e-9)
    for i in range(len(times) - 1):
        inside = path.vector_values(np.linspace(times[i], times[i + 1], 20)).T
        assert (inside >= np.minimum(points[i], points[i + 1]) - 1e-9).all()
        assert (inside <= np.maximum(points[i], points[i + 1]) + 1e-9).all()
    np.testing.assert_allclose(
        velocity.vector_values(times - 1e-9), velocity.vector_values(times + 1e-9), atol=1e-4
    )


def test_two_points_give_a_cubic_from_rest_to_rest(write):
    p, v = make_reference(Waypoints(str(write(GOOD))), START).evaluate(np.array([0.0, 1.0, 2.0]))
    np.testing.assert_allclose(p[:, 0], [0, 0.05, 0.1], atol=1e-12)
    np.testing.assert_allclose(v[:, 0], [0, 1.5 * 0.1 / 2, 0], atol=1e-12)


def test_endpoints_are_kept_outside_the_times_of_the_file(write):
    late = GOOD.replace(b"\n2,", b"\n7,").replace(b"\n0,", b"\n5,")
    p, v = make_reference(Waypoints(str(write(late))), START).evaluate(
        np.array([-1.0, 0.0, 4.9, 7.1, 1e6])
    )
    np.testing.assert_allclose(p, START + np.outer([0, 0, 0, 1, 1], [0.1, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(v, 0, atol=1e-12)


def test_a_path_may_start_elsewhere(write):
    curve = make_reference(Waypoints(str(write(GOOD))), START + 1.0)
    np.testing.assert_allclose(curve.evaluate(np.zeros(1))[0], [START])


def test_diameter_includes_the_path_between_the_points(write):
    curve = make_reference(Waypoints(str(PACKAGED)), START)
    times, points = read_waypoints(PACKAGED)
    brute = pdist(curve.evaluate(np.linspace(0, times[-1], 3000))[0]).max()
    assert brute <= curve.diameter_m == pytest.approx(brute, abs=1e-5)
    assert curve.diameter_m >= pdist(points).max()


def test_ten_thousand_rows_take_less_than_ten_seconds(write):
    s = np.linspace(0, np.pi, 10_000)  # A spiral on a sphere, where all points are outermost.
    points = np.stack([np.sin(s) * np.cos(41 * s), np.sin(s) * np.sin(41 * s), np.cos(s)], axis=1)
    rows = np.column_stack([0.01 * np.arange(10_000), points])
    path = write(b"t,x,y,z\n" + "\n".join(",".join(map(str, row)) for row in rows).encode())
    began = time.perf_counter()
    assert make_reference(Waypoints(str(path)), START).diameter_m == pytest.approx(2, abs=1e-4)
    assert time.perf_counter() - began < 10


def test_packaged_path_is_gentle_and_starts_at_the_end_effector():
    times, points = read_waypoints(PACKAGED)
    np.testing.assert_array_equal(points[0], START)
    assert times[0] == 0 and 20 <= times[-1] <= 30
    curve = make_reference(Waypoints(str(PACKAGED)), START)
    p, v = curve.evaluate(np.linspace(0, times[-1], 1000))
    assert np.linalg.norm(p - START, axis=1).max() < 0.6
    assert np.linalg.norm(v, axis=1).max() < 0.3

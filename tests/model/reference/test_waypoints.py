"""Tests of waypoint files, valid and invalid, and of the path through them."""

import io
import os
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from aerodrake.model.reference import direction
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.waypoints import (
    MAX_FILE_BYTES,
    interpolate_waypoints,
    read_waypoints,
)
from aerodrake.scenario import Waypoints
from aerodrake.support.errors import BadInput

read_directions = partial(read_waypoints, columns=direction.COLUMNS)
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
    "too fast": (b"t,x,y,z\n0,0,0,1\n0.0009,0,0,1\n", "row 3: expected t to ascend by"),
    "header again": (b"t,x,y,z\n0,0,0,1\nt,x,y,z\n1,0,0,1\n", "row 3: expected t"),
    "comments only": (b"# a\n# b\n", "header"),
    "another comment": (b"# time,x,y,z\n0,0,0,1\n1,0,0,1\n", "row 2: expected the header"),
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


NO_DECIMALS = (
    *("5_0", "\uff15", "\u0661", "0x1p3", "0x10", "1e", "e5", ".", "1,5", "1.5.2", "--1", "+-1"),
    *(
        "nan",
        "NaN",
        "inf",
        "-Infinity",
        "1d3",
        "1 2",
        "1j",
        "True",
        "0b1",
        "1e5_0",
        "1e400",
        "\u2212",
    ),
)


@pytest.mark.parametrize("text", NO_DECIMALS)
@pytest.mark.parametrize("column", range(4))
def test_other_spellings_of_numbers_are_refused(write, text, column):
    cells = ["1", "0.1", "0.2", "1.2"]
    cells[column] = f'"{text}"'
    path = write(GOOD.replace(b"\n2,0.1,0.2,1.2", b"\n\n" + ",".join(cells).encode()))
    with pytest.raises(
        BadInput, match=f"row 4: expected {'txyz'[column]} in .* as a decimal number"
    ):
        read_waypoints(path)


@settings(max_examples=30, deadline=None)
@given(st.floats(-1000, 1000), st.sampled_from(["{!r}", "{:.3f}", "{:+.9e}", "{:g}", " {:.1E} "]))
def test_decimal_numbers_are_read_as_python_reads_them(tmp_path_factory, number, form):
    path = tmp_path_factory.getbasetemp() / "numbers.csv"
    text = form.format(number)
    path.write_text(f"t,x,y,z\n0,{text},0,1\n1.,.5,-0,+1\n")
    assert read_waypoints(path)[1].tolist() == [[float(text), 0, 1], [0.5, 0, 1]]


FORMS = {
    "decimals": lambda times: [f"{t:.6f}" for t in times],
    "digits": lambda times: [f"{t:.9g}" for t in times],
    "all digits": lambda times: map(repr, times.tolist()),
    "single precision": lambda times: map(str, times.astype(np.float32)),
    "10 us": lambda times: [f"{t:.5f}" for t in times],
}


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from(sorted(FORMS)),
    st.sampled_from(["multiples", "sum"]),
    st.floats(1.0, 1000.0),
    st.floats(0.0, 250.0),
)
def test_rounding_of_times_is_tolerated(tmp_path_factory, form, way, rate, first):
    """Rates up to 1 kHz, in any spelling; times are multiples of a step, or sums of steps."""
    count = min(300, int((256 - first) * rate) + 2)
    if way == "multiples":
        times = first + np.arange(count) / rate
    else:
        times = first + np.cumsum(np.full(count, 1 / rate))
    path = tmp_path_factory.getbasetemp() / "times.csv"
    texts = list(FORMS[form](times))
    for header, read in (("t,x,y,z", read_waypoints), ("t,ax,ay,az", read_directions)):
        path.write_text(f"{header}\n" + "".join(f"{text},0,0,1\n" for text in texts))
        assert read(path)[0].tolist() == [float(text) for text in texts]


def test_ten_seconds_at_one_kilohertz_are_read(write):
    times = np.arange(10_000) * 1e-3
    assert (np.diff(times) < 1e-3).sum() > 1000
    rows = "".join(f"{t!r},0,0,1\n" for t in times.tolist())
    np.testing.assert_array_equal(read_waypoints(write(b"t,x,y,z\n" + rows.encode()))[0], times)


def test_files_of_numpy_and_of_spreadsheets_are_read(write):
    expected = [[0, 0, 0.2, 1.2], [2, 0.1, 0.2, 1.2]]
    text = io.StringIO()
    np.savetxt(text, expected, delimiter=",", header="recorded\nt,x,y,z")
    for content in (
        text.getvalue(),
        "# from a survey\n\n t,x,y,z # s and m\n0,0,0.2,1.2\n  # a pause\n2,0.1,0.2,1.2\n \n\t\n",
        '\ufeff"t","x","y","z"\r\n"0","0","0.2","1.2"\r\n2,0.1,0.2,1.2\r\n,,,\r\n\r\n',
        "t,x,y,z\r0,0,.2,1.2\r2.,1e-1,0.2,1.2\r",
    ):
        times, points = read_waypoints(write(content.encode()))
        np.testing.assert_array_equal(np.column_stack([times, points]), expected)


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

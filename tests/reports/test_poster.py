"""The still picture of a flight."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from matplotlib import pyplot as plt
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere

from aerodrake.reports.poster import SIZE_PX, _triangles, poster

pytestmark = pytest.mark.filterwarnings("error")


def pixels(picture: str) -> np.ndarray:
    return plt.imread(io.BytesIO(base64.b64decode(picture)))[..., :3]


@pytest.fixture(scope="module")
def picture(short_flight) -> str:
    scenario, log = short_flight
    return poster(log, scenario)


def test_it_shows_the_vehicle_in_its_colours(picture):
    """The body is dark and light grey, and parts of it orange."""
    seen = pixels(picture)
    assert seen.shape[:2] == SIZE_PX[::-1]
    orange = (seen[..., 0] > 0.6) & (seen[..., 2] < 0.35)
    dark = seen.max(axis=2) < 0.3
    assert min(np.count_nonzero(orange), np.count_nonzero(dark)) > 800
    rows, columns = np.nonzero(dark)
    assert np.ptp(columns) > 500 and 200 < columns.mean() < 880 and 150 < rows.mean() < 600
    assert len(picture) < 200_000


def test_the_same_flight_gives_the_same_bytes(picture, short_flight):
    scenario, log = short_flight
    assert poster(log, scenario) == picture


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300, 0.0])
def test_any_flight_has_one(value, short_flight):
    """Without one valid pose, the vehicle is at its start."""
    scenario, log = short_flight
    nothing = {key: np.full_like(rows, value) for key, rows in log.signals.items()}
    spoilt = replace(log, signals={**nothing, "time_s": log.time_s})
    assert np.count_nonzero(pixels(poster(spoilt, scenario)).max(axis=2) < 0.3) > 2000


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Box(1.0, 2.0, 3.0), 6.0),
        (Sphere(2.0), 4 / 3 * np.pi * 8),
        (Ellipsoid(1.0, 2.0, 3.0), 4 / 3 * np.pi * 6),
        (Cylinder(2.0, 3.0), np.pi * 12),
        (Capsule(1.0, 3.0), np.pi * 3 + 4 / 3 * np.pi),
    ],
)
def test_triangles_enclose_the_volume_of_a_shape(shape, volume):
    """Polyhedra inscribed into round shapes have up to 15 % less; all are around the origin."""
    enclosed = np.abs(np.linalg.det(_triangles(shape))).sum() / 6
    assert 0.85 * volume <= enclosed <= volume + 1e-9


def test_unbounded_shapes_are_left_out():
    assert _triangles(HalfSpace()).shape == (0, 3, 3)

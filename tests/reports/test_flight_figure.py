"""The figure of a flight, all on one sheet."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.flight_log import FlightLog
from aerodrake.reports.flight_figure import plot_tracking


def test_the_tools_angle_has_a_panel_where_there_is_one(short_flight, tmp_path):
    _, log = short_flight
    heights = []
    for d in (0 * log["tool_axis"], log["tool_axis"]):
        pointed = FlightLog({**log.signals, "tool_axis_d": d}, "completed", "", 1.0)
        plot_tracking(pointed, short_flight[0], "title", tmp_path / "a.png")
        heights.append(plt.imread(tmp_path / "a.png").shape[0])
    assert heights[1] > heights[0]


@pytest.fixture(scope="module")
def figure(short_flight, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("report") / "a.png"
    plot_tracking(short_flight[1], short_flight[0], "title", path)
    return path


def test_the_same_flight_gives_the_same_bytes(figure, short_flight, tmp_path):
    plot_tracking(short_flight[1], short_flight[0], "title", tmp_path / "again.png")
    content = figure.read_bytes()
    assert content == (tmp_path / "again.png").read_bytes()
    assert b"matplotlib" not in content.lower()
    assert plt.get_fignums() == []


def test_the_figure_shows_the_flight(figure, short_flight, tmp_path):
    """Large enough to read, more than one colour, and another one for another flight."""
    _, log = short_flight
    moved = FlightLog({**log.signals, "p_E_m": log["p_E_m"] + 0.01}, "completed", "", 1.0)
    plot_tracking(moved, short_flight[0], "title", tmp_path / "b.png")
    a, b = plt.imread(figure), plt.imread(tmp_path / "b.png")
    assert a.shape == b.shape and min(a.shape[:2]) > 1000
    assert np.abs(a - b).max() > 0.5
    assert len(np.unique(a.reshape(-1, a.shape[2])[::50], axis=0)) > 20


@pytest.mark.parametrize("title", ["$x^$ a_b ^ \\frac{ ü <b>"])
def test_titles_are_plain_text(title, short_flight, tmp_path):
    plot_tracking(short_flight[1], short_flight[0], title, tmp_path / "a.png")


@pytest.mark.parametrize("samples", [2, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_are_drawn(samples, short_flight, tmp_path):
    """Before and just after reference time 0; and to numbers that are none."""
    _, log = short_flight
    signals = {key: rows[:samples].copy() for key, rows in log.signals.items()}
    for key in ("quaternion", "p_B_m", "q_rad", "p_E_m"):
        signals[key][-1] = np.nan
    plot_tracking(FlightLog(signals, "lost", "", 1.0), short_flight[0], "early", tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000

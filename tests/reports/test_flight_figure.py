"""The figure of a flight, all on one sheet."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.reports.flight_figure import plot_tracking
from tests.flights import lost_early


@pytest.fixture(scope="module")
def figure(short_flight, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("report") / "a.png"
    plot_tracking(short_flight[1], short_flight[0], "title", path)
    return path


def test_the_tools_angle_has_a_panel_with_the_orientation_task(figure, short_flight, tmp_path):
    scenario, log = short_flight
    assert log.tool_angle_rad is None
    pointed = replace(log, signals={**log.signals, "tool_axis_d": log["tool_axis"]})
    plot_tracking(pointed, scenario, "title", tmp_path / "a.png")
    assert plt.imread(tmp_path / "a.png").shape[0] > plt.imread(figure).shape[0]


def test_the_same_flight_gives_the_same_bytes(figure, short_flight, tmp_path):
    plot_tracking(short_flight[1], short_flight[0], "title", tmp_path / "again.png")
    content = figure.read_bytes()
    assert content == (tmp_path / "again.png").read_bytes()
    assert b"matplotlib" not in content.lower()
    assert plt.get_fignums() == []


def test_the_figure_shows_the_flight(figure, short_flight, tmp_path):
    """Large enough to read, more than one colour, and another one for another flight."""
    _, log = short_flight
    moved = replace(log, signals={**log.signals, "p_E_m": log["p_E_m"] + 0.01})
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
    """Before and just after reference time 0, with NaN in the last sample."""
    _, log = short_flight
    plot_tracking(lost_early(log, samples), short_flight[0], "early", tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000

"""The table and the figure of a flight."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.flight_log import FlightLog
from aerodrake.flight_table import table
from aerodrake.report import plot_tracking
from aerodrake.summary import summarize


@pytest.fixture
def summary(short_flight):
    return summarize(*short_flight)


def lines(text: str) -> dict[str, list[str]]:
    """The cells of a table's rows by their label."""
    rows = [line for line in text.splitlines() if len(line) > 24]
    return {row[:24].strip(): row[24:].split("  ") for row in rows}


def cell(text: str, label: str) -> list[str]:
    return [cell.strip() for cell in lines(text)[label] if cell.strip()]


def test_the_papers_figures_stand_beside_ours(summary):
    """The paper, section V: 12.2 mm on the clover; 19.7 mm from 15 s, within 5 s."""
    summary["error"] |= {"lap_mean_m": 0.00125, "settled_mean_m": 0.0002, "approach_s": 2.2}
    clover = table(summary, "clover")
    assert cell(clover, "mean over one lap") == ["1.25 mm", "12.20 mm"]
    assert cell(clover, "mean after 15 s") == ["0.20 mm"]
    target = table(summary, "moving_target")
    assert cell(target, "mean after 15 s") == ["0.20 mm", "19.70 mm"]
    assert cell(target, "first within d_h") == ["2.20 s", "5.00 s"]
    assert cell(target, "mean over one lap") == ["1.25 mm"]


@pytest.mark.parametrize("kind", ["hover", "lissajous", "figure_eight", "waypoints", "unheard_of"])
def test_other_flights_have_no_figures_of_the_paper(summary, kind):
    text = table(summary, kind)
    assert cell(text, "mean") == [f"{1e3 * summary['error']['mean_m']:.2f} mm"]
    assert "12.20" not in text and "19.70" not in text


def test_what_was_not_flown_is_left_out_or_empty(summary):
    text = table(summary, "clover")
    assert "None" not in text and "nan" not in text
    assert cell(text, "mean over one lap") == ["12.20 mm"]
    assert all(line == line.rstrip() for line in text.splitlines())


def test_it_says_how_the_flight_ended(summary):
    assert table(summary, "clover").startswith("short: completed\n")
    summary |= {"exit_reason": "lost", "exit_cause": "tilt of 61 deg at 2.00 s"}
    assert table(summary, "clover").startswith("short: lost (tilt of 61 deg at 2.00 s)\n")


def test_the_tools_angle_is_shown_where_there_is_one(summary, short_flight, tmp_path):
    assert "tool's angle" not in table(summary, "clover")
    summary["orientation"] |= {"mean_rad": np.deg2rad(0.5), "max_rad": np.deg2rad(2)}
    text = table(summary, "clover")
    assert cell(text, "tool's angle, mean") == ["0.500 deg"]
    assert cell(text, "tool's angle, max") == ["2.000 deg"]

    _, log = short_flight
    heights = []
    for d in (0 * log["tool_axis"], log["tool_axis"]):
        pointed = FlightLog({**log.signals, "tool_axis_d": d}, "completed", "", 1.0)
        plot_tracking(pointed, short_flight[0], "title", tmp_path / "a.png")
        heights.append(plt.imread(tmp_path / "a.png").shape[0])
    assert heights[1] > heights[0]


def test_table_of_a_flight_that_never_came_to_reference_time(short_flight):
    scenario, log = short_flight
    early = FlightLog({k: v[:5] for k, v in log.signals.items()}, "interrupted", "at 0 s", 1.0)
    text = table(summarize(scenario, early), "clover")
    assert "None" not in text and "nan" not in text


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

"""Reports of flights that end before reference time 0, or at once."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from aerodrake.comparison.figure import draw_errors, plot_comparison
from aerodrake.flight.log import PER_TICK, FlightLog
from aerodrake.reports.figures import LEAST_TIME_S, cover
from aerodrake.reports.flight_panels import draw_distance, draw_error, draw_paths, draw_plan
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.reports.residual_panels import residuals


def early(log: FlightLog, samples: int) -> FlightLog:
    """Returns a log of a flight that is lost in the initial hover."""
    signals = {k: rows if k in PER_TICK else rows[:samples] for k, rows in log.signals.items()}
    return replace(
        log,
        signals={**signals, "time_s": signals["time_s"] - 5.0},
        exit_reason="lost",
        exit_cause="",
    )


@pytest.mark.parametrize("samples", [1, 30])
def test_the_flown_part_is_drawn(samples, short_flight):
    scenario, log = short_flight
    log = early(log, samples)
    flat, space = Figure().add_subplot, Figure().add_subplot
    panels = [flat(), flat(), flat(), flat(), space(projection="3d")]
    draw_plan(panels[0], log)
    draw_error(panels[1], log)
    draw_distance(panels[2], log)
    draw_errors(panels[3], {"modified": log}, 1)
    draw_paths(panels[4], log)
    for axes in panels:
        assert axes.lines and all(len(line.get_xdata()) == samples for line in axes.lines)


def test_is_flown_begins_at_reference_time_0(short_flight):
    _, log = short_flight
    assert log.time_s[0] < 0 < log.time_s[-1]
    np.testing.assert_array_equal(log.is_flown, log.time_s >= 0)
    assert early(log, 3).is_flown.all()


def test_the_residual_begins_with_the_flight(short_flight):
    scenario, log = short_flight
    times, *_ = residuals(early(log, 60), scenario)
    assert len(times) > 20 and -5.2 < times[0] < times[-1] < -4.5


@pytest.mark.parametrize("times", [[-3.0], [-3.0, -2.0], [0.0, 9.0]])
def test_the_time_axis_covers_the_times(times):
    axes = Figure().add_subplot()
    cover(axes, np.array(times))
    low, high = axes.get_xlim()
    assert low == times[0] and high == max(times[-1], low + LEAST_TIME_S)


@pytest.mark.parametrize("samples", [1, 12])
@pytest.mark.filterwarnings("error")
def test_all_pictures_are_drawn_without_warnings(samples, short_flight, tmp_path):
    scenario, log = short_flight
    log = early(log, samples)
    for picture in flight_pictures(log, scenario):
        assert len(re.findall("<path", picture.svg)) > 3, picture.title
    logs = {"modified": log, "modified+online": log}
    plot_comparison(logs, "modified", scenario, "title", tmp_path / "a.png")

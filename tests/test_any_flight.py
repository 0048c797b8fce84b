"""Figures and pages of any flight that ended, whatever its numbers are."""

import re
from dataclasses import replace

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from aerodrake.comparison.figure import plot_comparison
from aerodrake.comparison.margin_search import Outcome, Search
from aerodrake.comparison.margins import DISTURBANCES, Margins
from aerodrake.comparison.margins_report import plot_margins
from aerodrake.comparison.page import _pictures as comparison_pictures
from aerodrake.flight.log import PER_TICK, FlightLog
from aerodrake.flight.summary import summarize, to_json
from aerodrake.identification.identify import (
    ARMS,
    AXES,
    AxisIdentification,
    Identification,
    Record,
)
from aerodrake.identification.report import plot_identification
from aerodrake.learning.report import DeltaFlight, plot_training
from aerodrake.model.equivalent.identification import GainFit
from aerodrake.model.residual.training import TrainingResult
from aerodrake.reports.drawable import LARGEST, drawable
from aerodrake.reports.flight_figure import plot_tracking
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.reports.flight_table import highlights, table
from aerodrake.reports.replay import replay_page
from aerodrake.scenario import Scenario

pytestmark = pytest.mark.filterwarnings("error")

CODES = {"mode", "supervisor_mode", "supervisor_cause", "qp_status", "delta_source"}
"""Numbers of enumerations, which the recording keeps valid."""

VALUES = (
    *(np.nan, np.inf, -np.inf, 1e24, -1e24, 1e300, -1.7e308, 1.7e308, 1e154, LARGEST, 2 * LARGEST),
    *(0.0, -1.0, 1e-12, 5e-324),
)


def spoilt(log: FlightLog, seed: int) -> FlightLog:
    """Returns a short log in which some signals have some of `VALUES`, in part or as a whole."""
    rng = np.random.default_rng(seed)
    samples = rng.choice([1, 2, 12, len(log.time_s)])
    signals = {k: (v if k in PER_TICK else v[:samples]).copy() for k, v in log.signals.items()}
    signals["time_s"] -= rng.choice([0.0, 5.0])  # Lost in the initial hover.
    signals["tick_ms"] = signals["tick_ms"][: rng.choice([0, 1, 1000])]
    keys = sorted(signals.keys() - CODES - {"time_s"})
    for key in rng.choice(keys, size=rng.choice([1, 4, len(keys)]), replace=False):
        part = rng.random(signals[key].shape) < rng.choice([0.02, 0.5, 1.0])
        signals[key][part] = rng.choice(VALUES, size=np.count_nonzero(part))
    return replace(log, signals=signals, exit_reason="lost", exit_cause="")


@pytest.fixture
def examples(long) -> int:
    return 300 if long else 2


def test_all_is_drawn_of_any_flight(short_flight, tmp_path, examples):
    scenario, flown = short_flight

    @hypothesis.settings(max_examples=examples)
    @hypothesis.given(st.integers(0, 2**32 - 1))
    def check(seed):
        log = spoilt(flown, seed)
        plot_tracking(log, scenario, "title", tmp_path / "a.png")
        for picture in flight_pictures(log, scenario):
            assert len(re.findall("<path", picture.svg)) > 3, picture.title
        assert replay_page(log, scenario).rstrip().endswith("</html>")
        logs = {"modified": log, "modified+online": spoilt(flown, seed + 1)}
        plot_comparison(logs, "modified", scenario, "title", tmp_path / "b.png")
        assert [*comparison_pictures(logs, "modified", scenario)]
        summary = summarize(scenario, log)
        assert to_json(summary) and table(summary, "clover") and highlights(summary, "clover")

    check()


@pytest.mark.parametrize("value", [np.nan, 1e300])
def test_a_flight_without_one_number_is_drawn(value, short_flight, tmp_path):
    """Not even its modes are numbers."""
    scenario, log = short_flight
    nothing = {key: np.full(rows.shape, value) for key, rows in log.signals.items()}
    log = replace(log, signals={**nothing, "time_s": log.time_s})
    plot_tracking(log, scenario, "title", tmp_path / "a.png")
    assert len([*flight_pictures(log, scenario)]) > 8
    assert replay_page(log, scenario).rstrip().endswith("</html>")


def test_values_that_cannot_be_drawn_are_gaps(short_flight):
    _, log = short_flight
    rows = log["p_E_m"].copy()
    rows[0], rows[1, 0], rows[2, 2] = np.inf, -1e24, np.nan
    drawn = drawable(replace(log, signals={**log.signals, "p_E_m": rows}))["p_E_m"]
    assert np.isnan(drawn[0]).all() and np.isnan([drawn[1, 0], drawn[2, 2]]).all()
    assert np.count_nonzero(np.isnan(drawn)) == 5
    np.testing.assert_array_equal(drawn[3:], log["p_E_m"][3:])


@pytest.mark.parametrize("value", [np.nan, 1e300])
def test_an_identification_is_drawn(value, tmp_path):
    time_s = 0.02 * np.arange(20)
    record = Record(time_s, *(np.full(20, value) for _ in range(3)))
    fit = GainFit(gain=2.0, interval=(value, value), r2=value)
    axis = AxisIdentification(fit, dict.fromkeys(ARMS, record), dict.fromkeys(ARMS, 2.0))
    axes = dict.fromkeys(AXES, axis)
    plot_identification(Identification(Scenario(), axes), tmp_path / "a.png")


@pytest.mark.parametrize(("value", "rows"), [(1.0, 0), (-1.0, 1), (1e300, 1), (np.nan, 20)])
def test_a_training_is_drawn(value, rows, tmp_path):
    losses = [value] * rows
    result = TrainingResult(None, losses, losses, 0)
    delta = DeltaFlight("title", 0.02, "m/s", *[np.full((rows, 3), value)] * 2)
    plot_training(result, delta, tmp_path / "a.png")


@pytest.mark.parametrize("error_m", [None, 1e300])
def test_margins_are_drawn(error_m, tmp_path):
    search = Search([0.0, 1.0, 2.0], {i: Outcome(error_m, "completed") for i in range(3)})
    margins = Margins("mean_m", {"modified": dict.fromkeys(DISTURBANCES, search)})
    plot_margins(margins, "title", tmp_path / "a.png")

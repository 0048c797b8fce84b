"""The summary of made-up logs: errors over the windows of the paper."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.summary import summarize, to_json
from aerodrake.scenario import Clover, Hover, MovingTarget, Scenario
from tests.logs import CLOVER, figures, made


def steps(t):
    """1 mm, then 2 mm from 3 s, 4 mm from 15 s, 8 mm after 27 s; and 1 m in the hover before."""
    levels = [t < 0, t < 3 - 1e-9, t < 15 - 1e-9, t < 27 + 1e-9]
    return np.select(levels, [1.0, 0.001, 0.002, 0.004], 0.008)


@pytest.mark.parametrize("which", ["error", "base_error"])
def test_errors_over_the_windows_of_the_paper(which):
    """300 samples of 1 mm, 1200 of 2, 1201 of 4 (both ends of the lap count), 300 of 8."""
    error = figures(made(**{which: steps}))[which]
    total = 300 + 1200 + 1201 + 300
    assert error["mean_m"] == pytest.approx((0.3 + 2.4 + 4.804 + 2.4) / total)
    squares = 300 * 1 + 1200 * 4 + 1201 * 16 + 300 * 64
    assert error["rms_m"] == pytest.approx(1e-3 * math.sqrt(squares / total))
    assert error["max_m"] == pytest.approx(0.008)
    assert error["lap_mean_m"] == pytest.approx((2.4 + 4.804) / (1200 + 1201))
    assert error["settled_mean_m"] == pytest.approx((4.804 + 2.4) / (1201 + 300))
    assert error["approach_s"] == 0


def test_errors_of_end_effector_and_base_are_independent():
    both = figures(made(error=steps))
    assert both["base_error"]["max_m"] == 0 and both["error"]["max_m"] > 0


def test_approach_is_the_first_time_within_d_h():
    def error(t):
        return np.where(np.abs(t - 2.2) < 0.005, 0.0749, np.where(t < 5, 0.0751, 0.01))

    scenario = Scenario(reference=MovingTarget(), settle_s=1)
    assert figures(made(error), scenario)["error"]["approach_s"] == pytest.approx(2.2)


def test_the_approach_does_not_count_in_the_initial_hover():
    error = figures(made(lambda t: np.where(t < 0, 0.0, 1.0)))["error"]
    assert error["approach_s"] is None


@pytest.mark.parametrize(
    ("until_s", "flown"),
    [
        (-0.1, set()),
        (0.1, {"mean_m", "rms_m", "max_m", "approach_s"}),
        (14.99, {"mean_m", "rms_m", "max_m", "approach_s"}),
        (15.0, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m"}),
        (26.99, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m"}),
        (27.0, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m", "lap_mean_m"}),
    ],
)
def test_windows_that_were_not_flown_are_null(until_s, flown):
    for which in ("error", "base_error"):
        error = figures(made(until_s=until_s))[which]
        assert {key for key, value in error.items() if value is not None} == flown


def test_another_reference_than_the_scenarios_has_no_lap_mean():
    faster = replace(CLOVER, reference=Clover(start_s=3, lap_s=20))
    error = figures(made(steps), faster)["error"]
    assert error["lap_mean_m"] is None and error["mean_m"] > 0


def test_references_without_laps_have_no_lap_mean():
    for reference in (Hover(), MovingTarget()):
        scenario = Scenario(reference=reference, settle_s=1)
        assert figures(made(), scenario)["error"]["lap_mean_m"] is None


def test_the_same_flight_gives_the_same_text():
    assert to_json(summarize(CLOVER, made(steps))) == to_json(summarize(CLOVER, made(steps)))

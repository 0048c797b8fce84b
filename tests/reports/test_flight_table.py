"""The figures of a flight, beside the paper's."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.summary import summarize
from aerodrake.reports.flight_table import highlights, table


@pytest.fixture
def summary(short_flight):
    return summarize(*short_flight)


def lines(text: str) -> dict[str, list[str]]:
    """The cells of a table's rows by their label."""
    rows = [line for line in text.splitlines() if len(line) > 24]
    return {row[:24].strip(): row[24:].split("  ") for row in rows}


def cell(text: str, label: str) -> list[str]:
    return [cell.strip() for cell in lines(text)[label] if cell.strip()]


def test_the_papers_figures_are_beside_ours(summary):
    """The paper, section V: 12.2 mm on the clover; 19.7 mm from 15 s, within 5 s."""
    summary["error"] |= {"lap_mean_m": 0.00125, "settled_mean_m": 0.0002, "approach_s": 2.2}
    clover = table(summary, "clover")
    assert cell(clover, "mean over one lap") == ["1.25 mm", "12.20 mm"]
    assert cell(clover, "mean after 15 s") == ["0.200 mm"]
    target = table(summary, "moving_target")
    assert cell(target, "mean after 15 s") == ["0.200 mm", "19.70 mm"]
    assert cell(target, "first within d_h") == ["2.20 s", "5.00 s"]
    assert cell(target, "mean over one lap") == ["1.25 mm"]


@pytest.mark.parametrize("kind", ["hover", "lissajous", "figure_eight", "waypoints", "unheard_of"])
def test_other_flights_have_no_figures_of_the_paper(summary, kind):
    summary["error"] |= {"mean_m": 0.0042}
    text = table(summary, kind)
    assert cell(text, "mean") == ["4.20 mm"]
    assert "12.20" not in text and "19.70" not in text


def test_undefined_figures_are_left_out_or_empty(summary):
    text = table(summary, "clover")
    assert "None" not in text and "nan" not in text
    assert cell(text, "mean over one lap") == ["12.20 mm"]
    assert all(line == line.rstrip() for line in text.splitlines())


def test_torques_at_their_limit_are_shown_with_the_joint(summary):
    assert "torque at limit" not in table(summary, "clover")
    summary["arm"]["torque_at_limit"] |= {"elbow_pitch": 0.6812, "arm_yaw": 0.0001}
    event = {"time_s": 1.0, "cause": "torque_at_limit", "mode": "nominal", "event": "triggered"}
    summary["events"].append(event | {"joint": "elbow_pitch"})
    text = table(summary, "clover")
    assert cell(text, "torque at limit") == ["of the time"]
    assert cell(text, "elbow_pitch") == ["68.1 %"]
    assert "1.00 s  torque_at_limit (elbow_pitch) triggered: nominal" in text
    assert "arm_yaw" not in text


def test_the_ending_of_the_flight_is_shown(summary):
    assert table(summary, "clover").startswith("short: completed\n")
    summary |= {"exit_reason": "lost", "exit_cause": "tilt of 61 deg at 2.00 s"}
    assert table(summary, "clover").startswith("short: lost (tilt of 61 deg at 2.00 s)\n")


def test_table_of_a_flight_that_ends_before_reference_time_0(short_flight):
    scenario, log = short_flight
    early = replace(
        log,
        signals={k: v[:5] for k, v in log.signals.items()},
        exit_reason="interrupted",
        exit_cause="at 0 s",
    )
    text = table(summarize(scenario, early), "clover")
    assert "None" not in text and "nan" not in text


def test_the_pointing_error_is_shown_with_the_orientation_task(summary):
    assert "pointing error" not in table(summary, "clover")
    summary["orientation"] |= {"mean_rad": np.deg2rad(0.5), "max_rad": np.deg2rad(2)}
    text = table(summary, "clover")
    assert cell(text, "pointing error, mean") == ["0.500 deg"]
    assert cell(text, "pointing error, max") == ["2.000 deg"]
    assert ("pointing error, mean", "0.500 deg", "") in highlights(summary, "clover")


def test_highlights_begin_with_the_figure_by_which_flights_are_compared(summary):
    summary["error"]["mean_m"] = 0.0042
    # The paper has no mean of all.
    assert highlights(summary, "clover")[0] == ("error, mean", "4.20 mm", "")
    summary["error"]["lap_mean_m"] = 0.00125
    lap = ("error, one lap", "1.25 mm", "the paper: 12.20 mm")
    assert highlights(summary, "clover")[0] == lap
    assert highlights(summary, "lissajous")[0] == (*lap[:2], "")


def learning(summary, **changes) -> str:
    """Returns the table of a flight that learned online."""
    learned = {"learned": 20.0, "offline": 3.0, "none": 0.0}
    rates = {"learning_rate": 0.0015, "stable_learning_rate": 0.0017}
    summary["residual"] |= {"source_s": learned} | rates | changes
    return table(summary, "clover")


def test_the_layer_in_use_and_its_learning_are_shown(summary):
    without = learning(summary, source_s=None, learning_rate=None, stable_learning_rate=None)
    assert "Delta" not in without and "learning" not in without
    text = learning(summary)
    assert cell(text, "time with learned Delta") == ["20.00 s"]
    assert cell(text, "time with offline Delta") == ["3.00 s"]
    assert cell(text, "learning rate") == ["0.0015"] and cell(text, "stable below") == ["0.0017"]
    assert "without Delta" not in text and "note" not in text
    text = learning(summary, learning_rate=None, stable_learning_rate=None)
    assert "learning rate" not in text and "note" not in text


def test_a_learning_rate_above_its_bound_is_noted(summary):
    text = learning(summary, stable_learning_rate=0.00026)
    assert text.splitlines()[-1].startswith(
        "note: residual.learning_rate 0.0015 exceeds 0.00026, the bound below which every step"
    )


def test_a_delta_that_was_never_used_is_shown(summary):
    event = {"time_s": 27.0, "cause": "delta_unused", "mode": "nominal", "event": "triggered"}
    summary["events"].append(event)
    text = learning(summary, source_s={"learned": 0.0, "offline": 0.0, "none": 27.0})
    assert cell(text, "residual Delta") == ["never used"] and "time without" not in text
    assert "   27.00 s  delta_unused triggered: nominal" in text


def test_missed_ticks_are_shown(summary):
    assert "MPC ticks missed" not in table(summary, "clover")
    summary["mpc"] |= {"ticks": 48, "missed": 277}
    assert cell(table(summary, "clover"), "MPC ticks missed") == ["277 of 325"]

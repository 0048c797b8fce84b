"""The table and the figure of a comparison."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.compare import VARIANTS
from aerodrake.comparison_report import plot_comparison
from aerodrake.comparison_table import comparison_table
from aerodrake.flight_log import FlightLog
from aerodrake.flight_table import headline
from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.initial_state import Thrust
from aerodrake.model.vehicle_state import VehicleState
from aerodrake.residual_panels import residuals
from aerodrake.summary import summarize


@pytest.fixture
def summaries(short_flight):
    """Of an integral model at 30.2 mm, another at 12.2 mm, one lost and one failed."""
    summary = summarize(*short_flight)

    def flown(lap_mean_m, reason="completed", cause=""):
        error = summary["error"] | {"lap_mean_m": lap_mean_m}
        return summary | {"error": error, "exit_reason": reason, "exit_cause": cause}

    return {
        "integral": flown(0.0302),
        "modified": flown(0.0122),
        "clik": flown(None, "lost", "tilt of 61 deg at 2.00 s"),
        "fixed_weights": {"exit_reason": "failed", "exit_cause": "MemoryError"},
    }


STATE = ("quaternion", "p_B_m", "q_rad", "omega_W_rad_s", "v_B_m_s", "qdot_rad_s")


def rows(text: str) -> dict[str, list[str]]:
    """The cells of each row by its first."""
    cells = [
        [c for c in line.replace(": ", ":").split("  ") if c.strip()]
        for line in text.splitlines()
        if line
    ]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in cells if len(row) > 1}


def test_rows_beside_the_papers(summaries):
    """59.6 % lower, as the paper has it of the same two numbers."""
    found = rows(comparison_table(summaries, "clover"))
    assert found["integral"][0] == found["paper:integral"][0] == "30.20"
    assert found["modified"][0] == found["paper:proposed"][0] == "12.20"
    assert found["modified"][2] == found["paper:proposed"][1] == "-59.6 %"
    assert found["modified"][-1] == "completed"
    target = rows(comparison_table(summaries, "moving_target"))
    assert target["paper:proposed"] == ["5.00"]  # It has no lap.
    assert "paper" not in comparison_table(summaries, "hover")


def test_what_was_lost_or_failed_is_shown(summaries):
    text = comparison_table(summaries, "clover")
    assert rows(text)["clik"][-1] == "lost:tilt of 61 deg at 2.00 s"
    assert rows(text)["fixed_weights"] == ["failed:MemoryError"]
    assert "None" not in text and "nan" not in text
    assert all(line == line.rstrip() for line in text.splitlines())


def test_headline_is_the_best_figure_that_was_flown(summaries):
    assert headline(summaries) == "lap_mean_m"
    for summary in list(summaries.values())[:3]:
        summary["error"] |= {"lap_mean_m": None, "settled_mean_m": None}
    assert headline(summaries) == "mean_m"
    summaries["clik"]["error"] |= {"settled_mean_m": 0.01}
    assert headline(summaries) == "settled_mean_m"
    assert headline({"clik": summaries["fixed_weights"]}) == "mean_m"


def test_without_the_integral_model_there_is_nothing_to_hold_against(summaries):
    del summaries["integral"]
    assert rows(comparison_table(summaries, "hover"))["modified"][2] != "-59.6 %"
    summaries["integral"] = summaries["fixed_weights"]
    assert " %" not in comparison_table(summaries, "hover")


def test_true_delta_is_what_the_model_lacked(short_flight):
    """With it, the model predicts the velocity that came; the estimate is what was inferred."""
    scenario, log = short_flight
    times, estimated, true = residuals(log, scenario)
    model = EquivalentModel.of(scenario, log["q_rad"].shape[1])
    assert len(times) > 15 and np.abs(true).max() > 1e-5 and estimated.any()
    # Logs see the state before an update: the filter's and u show one log later.
    x, starts = None, {}
    for i in range(0, len(log.time_s) - 1, 2):  # At the ticks, from the flight's first.
        state = np.hstack([log[part][i] for part in STATE])
        x = model.initial_state(
            log["p_B_m"][i],
            log["v_B_m_s"][i],
            np.concatenate([log["p_Bd_m"][i], log["v_Bd_m_s"][i], log["a_Bd_m_s2"][i]]),
            np.concatenate([log["q_d_rad"][i], log["qdot_d_rad_s"][i], log["qddot_d_rad_s2"][i]]),
            Thrust.make(
                VehicleState.from_vector(state),
                log["specific_thrust_m_s2"][i],
                log["external_acceleration_m_s2"][i + 1],
                log["disturbance_m_s2"][i],
            ),
            x,
        )
        starts[i] = x
    for time, delta in zip(times, true, strict=True):
        i = int(np.argmin(np.abs(log.time_s - time)))
        u = np.concatenate([log["a_Bd_m_s2"][i + 1], log["qddot_d_rad_s2"][i + 1]])
        predicted = model.predict(starts[i], u, delta)[model.base_velocity]
        np.testing.assert_allclose(predicted, log["v_B_m_s"][i + 2], atol=1e-9)


def draw(short_flight, path: Path, logs=None) -> np.ndarray:
    scenario, log = short_flight
    names = ("integral", "modified", "modified+online", "clik", "fixed_weights")
    logs = dict.fromkeys(names, log) if logs is None else logs
    plot_comparison(logs, "modified+online", scenario, "title", path)
    return plt.imread(path)


def test_the_figure_shows_every_variant(short_flight, tmp_path):
    _, log = short_flight
    all_of_them = draw(short_flight, tmp_path / "a.png")
    draw(short_flight, tmp_path / "again.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    assert min(all_of_them.shape[:2]) > 1000
    three = ("integral", "clik", "modified+online")
    one_row = draw(short_flight, tmp_path / "c.png", dict.fromkeys(three, log))
    for missing in ("clik", "modified+online"):
        others = dict.fromkeys(set(three) - {missing}, log)
        fewer = draw(short_flight, tmp_path / "b.png", others)
        assert np.abs(one_row - fewer).max() > 0.5
    assert plt.get_fignums() == []


@pytest.mark.filterwarnings("error")
def test_there_is_room_for_all_variants_that_there_are(short_flight, tmp_path):
    _, log = short_flight
    crowded = draw(short_flight, tmp_path / "a.png", dict.fromkeys(VARIANTS, log))
    assert len(crowded) > len(draw(short_flight, tmp_path / "b.png"))


@pytest.mark.parametrize("samples", [2, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_are_drawn(samples, short_flight, tmp_path):
    """Before and just after reference time 0, beside none that failed."""
    _, log = short_flight
    early = {key: rows[:samples].copy() for key, rows in log.signals.items()}
    for key in ("quaternion", "p_B_m", "q_rad", "p_E_m"):
        early[key][-1] = np.nan
    lost = FlightLog(early, "lost", "", 1.0)
    draw(short_flight, tmp_path / "a.png", {"modified+online": lost})
    draw(short_flight, tmp_path / "b.png", {"modified+online": lost, "clik": log})
    draw(short_flight, tmp_path / "c.png", {})

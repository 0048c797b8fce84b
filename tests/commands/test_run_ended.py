"""Flights by `aerodrake run` that end early, and drawings that fail."""

import json
from pathlib import Path

import pytest

from aerodrake.cli import main
from aerodrake.reports.flight_folder import DRAWINGS, RESULTS

FILES = sorted((*RESULTS, *DRAWINGS))

TINY = ["--duration", "0.1", "--set", "settle_s=0", "--quiet"]


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*"))


@pytest.mark.usefixtures("undrawn")
def test_a_lost_flight_exits_1_and_is_written(tmp_path, monkeypatch, capsys):
    """The vehicle falls, since its rotors are too weak; its loop is not analysed here."""
    sentence = "unstable in hover: roll at 9.6 Hz grows by 5.0 1/s"
    monkeypatch.setattr("aerodrake.api.fly.hover_instability", lambda *_: sentence)
    out = tmp_path / "run"
    weak = ["--set", "vehicle.rotor.max_thrust_n=2", "--set", "vehicle.base_position_m=[0, 0, 9]"]
    options = [*weak, "--set", "settle_s=0", "--duration", "2"]
    assert main(["run", "hover", *options, "--out", str(out)]) == 1
    figures = json.loads((out / "summary.json").read_text())
    assert figures["exit_reason"] == "lost" and figures["simulated_s"] < 2
    assert figures["instability"] == sentence
    assert f"hover: lost ({figures['exit_cause']})\n{sentence}\n" in capsys.readouterr().out
    assert f"The loop is {sentence}." in (out / "report.html").read_text()
    assert names_in(out) == FILES


@pytest.mark.usefixtures("undrawn")
def test_an_interrupted_flight_exits_1_and_is_written(tmp_path, monkeypatch):
    """The interrupt is before reference time 0."""
    import tqdm

    def interrupt(bar, step):
        raise KeyboardInterrupt

    monkeypatch.setattr(tqdm.tqdm, "update", interrupt)
    out = tmp_path / "run"
    options = ["--duration", "9", "--set", "settle_s=9", "--quiet"]
    assert main(["run", "hover", *options, "--out", str(out)]) == 1
    figures = json.loads((out / "summary.json").read_text())
    assert figures["exit_reason"] == "interrupted"
    assert figures["simulated_s"] == pytest.approx(0.1)
    assert figures["error"]["mean_m"] is None and sum(figures["modes"].values()) == 0
    assert names_in(out) == FILES


@pytest.mark.parametrize(
    ("step", "left"),
    [("flight.log.FlightLog.save", []), ("reports.flight_folder.plot_tracking", sorted(RESULTS))],
)
def test_an_interrupt_while_writing_leaves_all_results_or_none(
    step, left, tmp_path, monkeypatch, capsys
):
    """Those of a flight that is being drawn are complete."""

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"aerodrake.{step}", interrupt)
    out = tmp_path / "run"
    try:
        code = main(["run", "hover", *TINY, "--out", str(out)])
    except KeyboardInterrupt:  # pytest itself would stop.
        pytest.fail("expected an exit code")
    assert code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["run"][: len(left)]
    assert names_in(out) == left
    assert capsys.readouterr().err == "aerodrake: interrupted\n"


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "function", "error"),
    [
        ("tracking.png", "plot_tracking", ValueError("Axis limits\ncannot be NaN")),
        ("replay.html", "replay_page", SystemExit()),
        ("report.html", "report_page", MemoryError()),
    ],
)
def test_a_drawing_that_fails_is_left_out(name, function, error, tmp_path, monkeypatch, caplog):
    """One line names it; the results and the other drawings are kept, and can be replaced."""

    def fail(*_, **__):
        raise error

    out = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(f"aerodrake.reports.flight_folder.{function}", fail)
        assert main(["run", "hover", *TINY, "--out", str(out)]) == 0
    assert names_in(out) == sorted({*FILES} - {name})
    assert json.loads((out / "summary.json").read_text())["exit_reason"] == "completed"
    (line,) = caplog.messages
    assert (
        line.startswith(f"{out / name} is not drawn: {type(error).__name__}") and "\n" not in line
    )
    caplog.clear()
    assert main(["run", "hover", *TINY, "--out", str(out)]) == 0
    assert names_in(out) == FILES and not caplog.messages

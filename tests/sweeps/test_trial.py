"""Trials: each equals a flight of `aerodrake run` and has a row whatever its end."""

import errno
import json
import shlex

import pytest

from aerodrake.cli import main
from aerodrake.scenario.load import load_with_options, save_scenario
from aerodrake.support.errors import BadInput
from aerodrake.sweeps import trial as module
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.trial import fly_trial
from tests.plans import by_key

NOISY = [
    ("--set", "settle_s=0.04"),
    ("--set", "duration=0.1"),
    ("--set", "sensors.position_noise_m=0.001"),
]


def make(*vary: str, scenario="hover", changes=()):
    return Plan.make(load_with_options(scenario, [*NOISY, *changes]), by_key(vary), 9)


def test_a_row_equals_the_summary_of_the_run_without_wall_times(tmp_path):
    """The run is started by the command of the trial."""
    plan = make("wind.gust_m_s[1]=uniform(0, 2)", "residual.mode=choice(off, online)")
    path = save_scenario(plan.scenario, tmp_path)
    trial = plan.trial(4)
    row, timing = fly_trial(trial)
    aerodrake, *words = shlex.split(trial.command(path))
    assert aerodrake == "aerodrake"
    assert main([*words, "--quiet", "--out", str(tmp_path / "run")]) == 0
    figures = json.loads((tmp_path / "run" / "summary.json").read_text())
    for key in ("scenario", "version", "wall_s", "real_time_factor"):
        del figures[key]
    for key in ("median_ms", "p99_ms", "overruns"):
        del figures["mpc"][key]
    parameters = row.pop("parameters")
    assert row.pop("trial") == timing["trial"] == 4
    assert row == figures and row["error"]["mean_m"] > 0
    assert set(parameters) == {"wind.gust_m_s[1]", "residual.mode"}
    assert set(timing) == {"trial", "wall_s", "host", "process"} and timing["wall_s"] > 0


def test_rows_are_repeatable_and_differ_between_trials():
    plan = make("wind.gust_m_s[1]=uniform(0, 2)")
    assert fly_trial(plan.trial(1))[0] == fly_trial(plan.trial(1))[0]
    first, second = (fly_trial(plan.trial(i))[0] for i in (0, 1))
    assert first["seed"] != second["seed"] and first["error"] != second["error"]


def test_a_lost_flight_has_a_row():
    weak = ["vehicle.rotor.max_thrust_n=2", "vehicle.base_position_m=[0, 0, 9]", "duration=2"]
    plan = make(changes=[("--set", change) for change in weak])
    row, _ = fly_trial(plan.trial(0))
    assert row["exit_reason"] == "lost" and row["simulated_s"] < 2 and row["error"]["mean_m"] > 0


def test_values_out_of_range_are_refused_in_the_row():
    plan = make("payload.mass_kg=normal(0, 0.1)")
    rows = [fly_trial(plan.trial(i))[0] for i in range(9)]
    refused = [row for row in rows if row["exit_reason"] == "refused"]
    assert 1 < len(refused) < 8
    for row in rows:
        mass = row["parameters"]["payload.mass_kg"]
        assert (row in refused) == (mass < 0)
    for row in refused:
        mass = row["parameters"]["payload.mass_kg"]
        assert row["exit_cause"].startswith("payload.mass_kg: expected a number in [0,")
        assert str(mass)[:6] in row["exit_cause"] and set(row) == {
            "trial", "seed", "parameters", "exit_reason", "exit_cause"
        }  # fmt: skip


@pytest.mark.parametrize("error", [RuntimeError("no such\nluck"), SystemExit("no such")])
def test_an_error_has_a_row_with_its_cause(error, monkeypatch):
    """Drake raises SystemExit for violated conditions."""

    def fail(_):
        raise error

    monkeypatch.setattr(module, "FlightSimulation", fail)
    row, _ = fly_trial(make().trial(0))
    assert row["exit_reason"] == "failed"
    assert row["exit_cause"] == f"{type(error).__name__}: no such"


@pytest.mark.parametrize(
    "error",
    [OSError(errno.ENOSPC, "No space left on device"), MemoryError(), FileNotFoundError("/tmp")],
)
def test_errors_of_the_machine_are_raised(error, monkeypatch):
    """Errors that were converted to BadInput count as well."""

    def fail(_):
        raise error

    def convert(_):
        try:
            fail(_)
        except (OSError, MemoryError):
            raise BadInput("/tmp", "", "cannot be written") from None

    for flight, kind in ((fail, type(error)), (convert, BadInput)):
        monkeypatch.setattr(module, "FlightSimulation", flight)
        with pytest.raises(kind):
            fly_trial(make().trial(0))


def test_a_missing_file_is_refused_in_the_row():
    plan = make("vehicle.robot=choice(package://aerodrake/robots/none.urdf)")
    row, _ = fly_trial(plan.trial(0))
    assert row["exit_reason"] == "refused"
    assert row["exit_cause"].endswith(
        "none.urdf: expected a readable file: No such file or directory"
    )


@pytest.mark.parametrize("value", ["a b", "x'y", '"', "true", "1", "é"])
def test_values_are_quoted_for_the_shell(value, tmp_path):
    plan = make(f"name=choice({json.dumps(value)})")
    words = shlex.split(plan.trial(0).command(tmp_path / "my scenario.yaml"))
    assert words[:3] == ["aerodrake", "run", str(tmp_path / "my scenario.yaml")]
    overrides = [("--set", word) for word in words[4:5]]
    assert load_with_options("hover", overrides).name == value

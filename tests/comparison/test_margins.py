"""Disturbances, and the flights of their searches."""

import json
import re
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.cli import main
from aerodrake.comparison import compare as compare_module
from aerodrake.comparison import margins as module
from aerodrake.comparison.margins import DISTURBANCES, R40, Disturbance, find_margins
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.scenario import Mismatch, Payload, Rates, Scenario, Sensors
from aerodrake.scenario.load import load_with_options

TINY = ["--set", "duration=0.2", "--set", "settle_s=0"]


def test_preferred_numbers_are_rounded_powers_of_the_fortieth_root_of_ten():
    """ISO 3 rounds them by 1.3 % at most."""
    assert len(R40) == 40
    assert all(abs(number / 10 ** (k / 40) - 1) < 0.013 for k, number in enumerate(R40))


def test_the_values_span_the_documented_ranges():
    values = {name: disturbance.values(Scenario()) for name, disturbance in DISTURBANCES.items()}
    ends = {name: (numbers[0], numbers[1], numbers[-1]) for name, numbers in values.items()}
    assert ends == {
        "delay_s": (0.0, 0.001, 0.2),
        "thrust_up": (1.0, 1.06, 5.0),
        "thrust_down": (1.0, 0.95, 0.1),
        "payload_kg": (0.0, 0.04, 2.0),
    }
    assert 0.02 in values["delay_s"] and 0.3 in values["payload_kg"]
    assert 1.5 in values["thrust_up"] and 0.67 in values["thrust_down"]


@given(
    step=st.sampled_from([1e-4, 2.5e-4, 1e-3, 0.0025, 0.005]),
    delay=st.integers(0, 50),
    scale=st.floats(0.1, 5.0),
    mass=st.floats(0.0, 2.0),
    data=st.data(),
)
def test_all_values_are_valid_for_any_scenario(step, delay, scale, mass, data):
    scenario = Scenario(
        rates=Rates(plant_step_s=step),
        sensors=Sensors(base_delay_s=0.01 * delay),
        mismatch=Mismatch(thrust_scale=scale),
        payload=Payload(mass),
    )
    name = data.draw(st.sampled_from(list(DISTURBANCES)))
    disturbance = DISTURBANCES[name]
    values = disturbance.values(scenario)
    assert disturbance.apply(scenario, values[0]) == scenario
    distances = [abs(value - values[0]) for value in values]
    assert distances == sorted({*distances})  # In increasing order, without repetition.
    for value in values:
        disturbed = disturbance.apply(scenario, value)
        added = {
            "delay_s": disturbed.sensors.base_delay_s - 0.01 * delay,
            "thrust_up": disturbed.mismatch.thrust_scale / scale,
            "thrust_down": disturbed.mismatch.thrust_scale / scale,
            "payload_kg": disturbed.payload.mass_kg - mass,
        }
        assert added[name] == pytest.approx(value, abs=1e-9)
        assert disturbed.sensors.base_delay_s <= 0.5 and disturbed.payload.mass_kg <= 2.0
        assert 0.1 <= disturbed.mismatch.thrust_scale <= 5.0
        back = replace(
            disturbed,
            sensors=scenario.sensors,
            mismatch=scenario.mismatch,
            payload=scenario.payload,
        )
        assert back == scenario


# Searches without flights, of a response that is known.


def respond(scenario: Scenario) -> dict:
    """Responds with a doubled error at 30 ms, 1.5, 1/2 and 0.5 kg.

    The flight is lost at 70 ms and at 3, and fails from 1.25 kg on.
    """
    delay, scale, mass = (
        scenario.sensors.base_delay_s,
        scenario.mismatch.thrust_scale,
        scenario.payload.mass_kg,
    )
    if mass >= 1.25:
        raise RuntimeError("too heavy")
    if delay >= 0.07 or scale >= 3:
        return {"exit_reason": "lost", "exit_cause": "tilt"}
    growth = delay / 0.03 + max(2 * (scale - 1), 1 / scale - 1) + mass / 0.5
    return {
        "exit_reason": "completed",
        "exit_cause": "",
        "error": {"mean_m": 0.002 * (1 + growth)},
    }


def in_this_process(function, items, jobs, pick=0):
    """Replaces `run_parallel`; calls the first pending item, or the last with `pick` -1."""
    waiting, sent = [], 0
    while sent < len(items) or waiting:
        waiting += range(sent, len(items))
        sent = len(items)
        index = waiting.pop(pick)
        try:
            yield index, function(items[index])
        except Exception as error:
            yield index, error


def test_each_variant_has_its_own_margins(monkeypatch):
    monkeypatch.setattr(module, "_fly", respond)
    plain = Scenario()
    variants = {"plain": plain, "lost": plain}
    summaries = {"plain": respond(plain), "lost": {"exit_reason": "lost", "exit_cause": "tilt"}}
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    flown = []
    margins = find_margins(variants, summaries, "mean_m", 2, lambda: flown.append(1))
    searches = margins.searches["plain"]
    assert {name: (search.doubles, search.lost) for name, search in searches.items()} == {
        "delay_s": ((0.028, 0.03), (0.067, 0.071)),
        "thrust_up": ((1.4, 1.5), (2.8, 3.0)),
        "thrust_down": ((0.53, 0.5), (0.1, None)),
        "payload_kg": ((0.475, 0.5), (1.18, 1.25)),
    }
    assert len(flown) == sum(len(search.outcomes) - 1 for search in searches.values()) < 50
    assert all(len(search.outcomes) == 1 for search in margins.searches["lost"].values())
    assert margins.failed
    assert {o.exit_cause for o in margins.outcomes("plain")} >= {"RuntimeError: too heavy"}


def test_margins_do_not_depend_on_which_flight_ends_first(monkeypatch):
    monkeypatch.setattr(module, "_fly", respond)
    results = []
    for pick in (0, -1):
        monkeypatch.setattr(module, "run_parallel", partial(in_this_process, pick=pick))
        variants = dict.fromkeys(("a", "b"), Scenario())
        summaries = dict.fromkeys(variants, respond(Scenario()))
        results.append(find_margins(variants, summaries, "mean_m", 2))
    assert results[0] == results[1]


def test_margins_are_relative_to_the_scenario(monkeypatch):
    monkeypatch.setattr(module, "_fly", respond)
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    late = Scenario(sensors=Sensors(base_delay_s=0.03))
    margins = find_margins({"late": late}, {"late": respond(late)}, "mean_m", 1)
    assert margins.searches["late"]["delay_s"].lost == (0.04 - 0.002, 0.04)
    assert margins.searches["late"]["payload_kg"].doubles == (0.95, 1.0)


# Flights.


def test_a_flight_has_the_disturbance_added_to_the_plant_alone(monkeypatch):
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    disturbance = Disturbance("payload", "mass_kg", 0.0, 1.9, 2.0)
    monkeypatch.setattr(module, "DISTURBANCES", {"payload_kg": disturbance})
    scenario = load_with_options("hover", [("--set", word) for word in TINY[1::2]])
    exact = {"exit_reason": "completed", "exit_cause": "", "error": {"max_m": 0.0}}
    margins = find_margins({"modified": scenario}, {"modified": exact}, "max_m", 1)
    search = margins.searches["modified"]["payload_kg"]
    log = FlightSimulation(replace(scenario, payload=Payload(1.9))).fly()
    assert search.values == (0.0, 1.9, 2.0)
    assert search.outcomes[1].error_m == pytest.approx(log.error_m.max(), rel=1e-11)
    assert search.outcomes[2].error_m > search.outcomes[1].error_m > 1e-3
    assert search.doubles == (0.0, 1.9)


# The command.


@pytest.fixture
def short(monkeypatch):
    """Command `compare hover --margins` with two variants and one disturbance, in this process.

    The figure of the comparison, which has its own tests, is not drawn.
    """
    disturbance = Disturbance("payload", "mass_kg", 0.0, 1.9, 2.0)
    monkeypatch.setattr(module, "DISTURBANCES", {"payload_kg": disturbance})
    monkeypatch.setattr(
        "aerodrake.comparison.margins_report.COLUMNS", {"payload_kg": ("payload, kg", 1.0)}
    )
    monkeypatch.setattr(
        "aerodrake.comparison.margins_report.PANELS", {"payload / kg": ("payload_kg",)}
    )
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    monkeypatch.setattr(compare_module, "run_parallel", in_this_process)
    plot = "aerodrake.comparison.folder.plot_comparison"
    monkeypatch.setattr(plot, lambda *arguments: arguments[-1].touch())
    return ["compare", "hover", *TINY, "--margins", "--variant", "modified", "--variant", "clik"]


FILES = [
    *("clik", "comparison.json", "comparison.png", "margins.json", "margins.png", "modified"),
    "report.html",
    "scenario.yaml",
]


@pytest.mark.usefixtures("undrawn")
def test_the_command(short, tmp_path, capfd):
    out = tmp_path / "out"
    assert main([*short, "--out", str(out)]) == 0
    output, progress = capfd.readouterr()
    assert re.search(r"^clik +0.000 +0.000 .* completed$", output, re.MULTILINE)
    assert re.search(r"^clik +0.000 +0 +> 2$", output, re.MULTILINE)
    *_, last = output.rstrip().splitlines()
    assert last.startswith(f"{out}: ") and all(file in last for file in FILES if "." in file)
    assert "hover margins: 4flight" in progress
    assert sorted(path.name for path in out.iterdir()) == FILES
    figures = json.loads((out / "margins.json").read_text())
    comparison = json.loads((out / "comparison.json").read_text())
    assert (figures["scenario"], figures["error"]) == ("hover", "mean_m")
    assert list(figures["variants"]) == list(comparison["variants"]) == ["modified", "clik"]
    for name, entry in figures["variants"].items():
        undisturbed = comparison["variants"][name]["error"]["mean_m"]
        assert entry["error_m"] == undisturbed
        assert entry["payload_kg"]["flown"][0] == [0.0, undisturbed, "completed"]
        assert [row[0] for row in entry["payload_kg"]["flown"]] == [0.0, 1.9, 2.0]


@pytest.mark.usefixtures("undrawn")
def test_failed_flights_are_reported_and_lost_flights_are_results(
    short, tmp_path, monkeypatch, capsys
):
    lost = {"exit_reason": "lost", "exit_cause": "tilt"}
    monkeypatch.setattr(module, "_fly", lambda scenario: lost)
    assert main([*short[:-2], "--quiet", "--out", str(tmp_path / "out")]) == 0
    monkeypatch.setattr(module, "_fly", respond)
    assert main([*short[:-2], "--out", str(tmp_path / "out")]) == 1  # Replaces the folder.
    output = capsys.readouterr().out
    assert re.search(
        r"^modified +0.000 +0 +0  2 flights failed: RuntimeError: too heavy$", output, re.M
    )
    figures = json.loads((tmp_path / "out" / "margins.json").read_text())
    assert figures["variants"]["modified"]["payload_kg"] == {
        "doubles": {"last_before": 0.0, "first_crossed": 1.9},
        "lost": {"last_before": 0.0, "first_crossed": 1.9},
        "flown": [
            [0.0, pytest.approx(0, abs=1e-6), "completed"],
            [1.9, None, "failed"],
            [2.0, None, "failed"],
        ],
    }


@pytest.mark.usefixtures("undrawn")
def test_an_interrupt_writes_nothing(short, tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "run_parallel", interrupt)
    assert main([*short[:-2], "--quiet", "--out", str(tmp_path / "out")]) == 130
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr() == ("", "aerodrake: interrupted\n")

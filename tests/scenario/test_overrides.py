"""Overrides of a scenario from Python: values of any type at dotted keys, in any order."""

import re
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from aerodrake.scenario import Clover, Hover, Lissajous, Mpc, Push, RotorDegraded, Scenario, Wind
from aerodrake.scenario.load import load_scenario, override
from aerodrake.support.errors import BadInput, ScenarioError

PATH = Path("flight.yaml")


@pytest.mark.parametrize("value", [3, 3.0, np.float32(3), np.int64(3), np.array(3)])
def test_numbers_of_any_type(value):
    scenario = load_scenario("hover", {"duration": value, "mpc.horizon": value})
    assert scenario.duration == scenario.mpc.horizon == 3
    assert type(scenario.duration) is float and type(scenario.mpc.horizon) is int


@pytest.mark.parametrize("make", [list, tuple, np.array, np.float32])
def test_vectors_of_any_type(make):
    scenario = load_scenario("hover", {"mpc.k_e": make([1, 2, 3]), "model.k_b[1]": np.float64(4)})
    assert scenario.mpc.k_e == (1.0, 2.0, 3.0) and type(scenario.mpc.k_e[0]) is float
    assert scenario.model.k_b == (1.71, 4.0, 1.71)


def test_keywords_are_keys_and_come_last():
    scenario = load_scenario("hover", {"duration": 1, "seed": 2}, duration=3, **{"mpc.horizon": 4})
    assert (scenario.duration, scenario.seed, scenario.mpc.horizon) == (3.0, 2, 4)
    assert load_scenario("hover", name="mine").name == "mine"


def test_sections_and_mappings_replace_the_whole_section():
    wind = Wind(velocity_m_s=(2.0, 0.0, 0.0))
    faults = [Push(), {"kind": "rotor_degraded", "rotor": 1}]
    scenario = load_scenario("clover", wind=wind, faults=faults, mpc={"horizon": 4})
    assert scenario.wind == wind and scenario.mpc == Mpc(horizon=4)
    assert scenario.faults == (Push(), RotorDegraded(rotor=1))
    assert load_scenario("clover", reference=Hover()).reference == Hover()
    assert load_scenario("clover", {"vehicle.rotor": {"lag_up_s": 0.02}}).vehicle.rotor.lag_up_s


def test_a_kind_comes_before_its_keys_and_a_section_before_its_keys():
    changes = {
        "reference.amplitude_m[2]": 0.1,
        "reference.amplitude_m": (0.3, 0.3, 0.3),
        "reference.start_s": 2,
        "reference.kind": "lissajous",
    }
    for order in permutations(changes):
        scenario = load_scenario("clover", {key: changes[key] for key in order})
        assert scenario.reference == Lissajous(amplitude_m=(0.3, 0.3, 0.1), start_s=2.0)
    changes = {"faults[1].rotor": 2, "faults[1].kind": "rotor_degraded", "faults": [Push()] * 2}
    assert load_scenario("clover", changes).faults == (Push(), RotorDegraded(rotor=2))


def test_scenarios_and_files_are_paths_or_strings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    PATH.write_text("seed: 1\n")
    changes = {"reference.kind": "waypoints", "reference.file": Path("points.csv")}
    scenario = load_scenario(PATH, changes)
    assert scenario == load_scenario(str(PATH), changes)
    assert scenario.reference.file == str(tmp_path / "points.csv")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"mpc.horizn": 3}, "mpc.horizn: unknown key; did you mean 'horizon'?"),
        ({"mcp.horizon": 3}, "mcp: unknown section; did you mean 'mpc'?"),
        ({"durations": 3}, "durations: unknown key; did you mean 'duration'?"),
        ({"duration": -3}, "duration: expected a number in [0.02, 3600] s, got -3"),
        ({"duration": "3"}, "duration: expected a number in [0.02, 3600] s, got '3'"),
        ({"duration": True}, "duration: expected a number in [0.02, 3600] s, got True"),
        ({"duration": np.True_}, "duration: expected a number in [0.02, 3600] s, got True"),
        ({"duration": None}, "duration: expected a number in [0.02, 3600] s, got None"),
        ({"duration": np.nan}, "duration: expected a number in [0.02, 3600] s, got nan"),
        ({"mpc.horizon": 2.5}, "mpc.horizon: expected a whole number in [2, 200] stages, got 2.5"),
        ({"mpc.shortcut": 1}, "mpc.shortcut: expected true or false, got 1"),
        ({"model.k_b": np.ones(2)}, "model.k_b: expected a list of 3 numbers in 1/s, got 2"),
        ({"model.k_b": np.ones((3, 1))}, "model.k_b[0]: expected a number in [0.01, 50] 1/s"),
        ({"model.k_b[3]": 1}, "model.k_b: expected an index below 3, got [3]"),
        ({"faults[0].start_s": 3}, "faults[0]: unknown section; faults is a list of 0, whose"),
        ({"faults.start_s": 3}, "faults: unknown section; faults is a list of 0, whose first item"),
        ({"duration.x": 3}, "duration: unknown section; duration is a value"),
        ({"orientation.axis": 3}, "orientation.axis: unknown key; valid: none for kind off"),
        ({"controller": "mcp"}, "controller: unknown value 'mcp'; did you mean 'mpc'?"),
        ({"controller": Path("mpc")}, "controller: expected a string, got PosixPath('mpc')"),
        ({"mpc": Wind()}, "mpc: expected Mpc, got Wind("),
        ({"reference": Push()}, "reference: expected Hover or Clover or"),
        ({"faults": [Clover()]}, "faults[0]: expected SampleNan or"),
        ({"faults": Push()}, "faults: expected a list of mappings, got Push("),
        ({"wind": 3}, "wind: expected a mapping of keys to values, got 3"),
        ({"rates.mpc_period_s": 0.033}, "rates.mpc_period_s: expected a multiple of"),
        ({"source": "x"}, "source: unknown key"),
        ({3: 3}, "overrides: expected dotted keys, got 3"),
        ([("--set", "duration=3")], "overrides: expected a mapping of dotted keys to values, got"),
    ],
)  # fmt: skip
def test_a_bad_override_is_named_by_scenario_and_key(changes, expected):
    for change in (load_scenario, lambda name, keys: override(load_scenario(name), keys)):
        with pytest.raises(BadInput, match=f"^{re.escape(f'clover: {expected}')}"):
            change("clover", changes)


def test_overrides_are_an_argument_of_this_name():
    expected = load_scenario("clover", {"mpc.horizon": 10})
    assert load_scenario(name_or_path="clover", overrides={"mpc.horizon": 10}) == expected
    assert override(load_scenario("clover"), overrides={"mpc.horizon": 10}) == expected


@pytest.mark.parametrize("name", [None, 3, Scenario()])
def test_a_scenario_is_named_by_a_string_or_path(name):
    with pytest.raises(ScenarioError, match="^name_or_path: expected the name of a packaged"):
        load_scenario(name)


@pytest.mark.parametrize("scenario", [None, "clover", Mpc()])
def test_an_overridden_scenario_is_a_scenario(scenario):
    with pytest.raises(ScenarioError, match="^scenario: expected Scenario, got"):
        override(scenario, duration=3)


def test_an_overridden_scenario_keeps_its_other_keys():
    scenario = load_scenario("clover", seed=3)
    changed = override(scenario, {"mpc.horizon": 10}, duration=5)
    assert (changed.seed, changed.mpc.horizon, changed.duration) == (3, 10, 5.0)
    assert override(changed, mpc=scenario.mpc, duration=scenario.duration) == scenario
    assert override(Scenario()) == Scenario()

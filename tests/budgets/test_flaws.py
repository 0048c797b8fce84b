"""Flaws that a scenario can have, and their keys."""

from collections import Counter

import pytest

from aerodrake.budgets.flaws import FLAWS, SILENT, present_flaws, silence
from aerodrake.scenario.load import load_scenario, override, packaged_scenarios
from aerodrake.scenario.schema import as_mapping, flat

SECTIONS = ("sensors", "actuation", "air", "wind", "payload", "mismatch")

PARAMETERS = {
    "sensors.accelerometer.period_s",
    "sensors.tool.period_s",
    "wind.gust_correlation_s",
    "wind.quadratic_drag_n_s2_m2",
    "wind.linear_drag_n_s_m",
    "wind.reference_height_m",
}
"""Keys without effect if no flaw is present."""


def test_each_key_of_the_environment_belongs_to_one_flaw():
    keys = {key for key in flat(as_mapping(SILENT)) if key.split(".")[0] in SECTIONS}
    counts = Counter(key for flaw in FLAWS for key in flaw.keys if key.split(".")[0] in SECTIONS)
    assert counts.keys() == keys - PARAMETERS
    assert set(counts.values()) == {1}


@pytest.mark.parametrize("name", packaged_scenarios())
def test_a_scenario_without_its_flaws_has_the_default_environment(name):
    scenario = load_scenario(name)
    clean = override(scenario, silence(present_flaws(scenario)))
    assert not present_flaws(clean)
    values, defaults = flat(as_mapping(clean)), flat(as_mapping(SILENT))
    assert all(
        values[key] == defaults[key]
        for key in values
        if key.split(".")[0] in SECTIONS and key not in PARAMETERS
    )


def test_the_filter_assumes_no_delay_if_there_is_none():
    realistic = load_scenario("clover_realistic")
    delay = next(flaw for flaw in FLAWS if flaw.name == "known delay")
    assert override(realistic, silence([delay])).filter.delay_s == 0

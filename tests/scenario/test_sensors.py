"""Rules between the keys of the sensors and others."""

import pytest

from aerodrake.scenario import Filter, Scenario
from aerodrake.scenario.schema import build
from aerodrake.support.errors import ScenarioError


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("position.period_s", 0.0155, "expected a multiple of rates.plant_step_s"),
        ("tool.delay_s", 0.0155, "expected a multiple of rates.plant_step_s"),
        ("position.latency_s", [0.02, 0.01], "expected the least latency, then the largest"),
        ("position.latency_s", [0.0, 0.0001], "expected a multiple of rates.plant_step_s"),
        ("joints.period_s", 0.2, "expected less than supervisor.joints_outage_s"),
        ("joints.rate_filter_s", 0.01, "expected 0 s, since sensors.joints.rate is exact"),
    ],
)
def test_inconsistent_values_are_named(key, value, expected):
    section, name = key.split(".")
    with pytest.raises(ScenarioError, match=rf"f.yaml: sensors.{key}.*: {expected}"):
        build(Scenario, {"sensors": {section: {name: value}}}, "f.yaml")


def test_a_filter_needs_an_accelerometer_to_use_one():
    with pytest.raises(ScenarioError, match="filter.accelerometer_noise_m_s2: expected 0, since"):
        Scenario(filter=Filter(accelerometer_noise_m_s2=0.1))

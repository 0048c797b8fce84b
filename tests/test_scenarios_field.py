"""The field scenarios: their values, which are those of a world and not to be tuned."""

import dataclasses

import numpy as np
import pytest

from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.scenario.schema import as_mapping, flat

DEG = np.pi / 180

FIELD = {
    "actuation.rotor_dead_time_s": 0.005,
    "actuation.rotor_levels": 1000,
    "actuation.thrust_scatter": 0.05,
    "actuation.sag": 0.10,
    "actuation.coulomb_n_m": [0.1],
    "actuation.setpoint_latency_s": [0, 0.020],
    "sensors.joints.resolution_bits": 12,
    "sensors.joints.rate": "difference",
    "sensors.joints.rate_filter_s": 0.005,
    "sensors.position.period_s": 0.02,
    "sensors.position.latency_s": [0, 0.010],
    "sensors.position.stamp": "arrival",
    "sensors.attitude.period_s": 0.005,
    "sensors.attitude.rate_bias_rad_s": [0.01, 0.01, 0.01],
    "sensors.accelerometer.period_s": 0.005,
    "sensors.accelerometer.noise_m_s2": 0.05,
    "sensors.accelerometer.bias_m_s2": [0.05, 0.05, 0.05],
    "air.rotor_drag_n_s_m": 0.2,
    "air.inflow_s_m": 0.1,
    "mismatch.centre_of_mass_m": [0.005, 0.005, 0],
    "filter.accelerometer_noise_m_s2": 0.1,
}
"""Differences from `clover_realistic`."""

CALIBRATION = {
    "sensors.attitude.bias_rad": [0.3 * DEG, 0.3 * DEG, 0],
    "sensors.joints.zero_rad": [0.1 * DEG],
    "actuation.backlash_rad": [0.2 * DEG],
    "actuation.flexibility_rad_n_m": [0.1 * DEG],
}
TOOL = {
    "sensors.tool.period_s": 0.020,
    "sensors.tool.delay_s": 0.020,
    "sensors.tool.noise_m": 0.002,
}


def differences(name: str, other: str) -> dict[str, object]:
    """Returns the values of a packaged scenario that differ from those of another."""
    mine, theirs = (flat(as_mapping(load_scenario(n))) for n in (name, other))
    assert mine.keys() == theirs.keys()
    return {key: value for key, value in mine.items() if value != theirs[key] and key != "name"}


@pytest.mark.parametrize(
    ("name", "other", "expected"),
    [
        ("clover_field", "clover_realistic", FIELD),
        ("clover_field_calibration", "clover_field", CALIBRATION),
        ("clover_field_tool", "clover_field_calibration", TOOL),
    ],
)
def test_values(name, other, expected):
    found = differences(name, other)
    assert found.keys() == expected.keys()
    for key, value in expected.items():
        assert found[key] == (value if isinstance(value, str) else pytest.approx(value, rel=1e-7))


def test_the_moving_target_is_in_the_same_world():
    field, clean = load_scenario("moving_target_field"), load_scenario("moving_target")
    same = dataclasses.replace(load_scenario("clover_field"), name=field.name)
    same = dataclasses.replace(same, reference=clean.reference, duration=clean.duration)
    assert dataclasses.replace(field, source="") == dataclasses.replace(same, source="")


def test_each_section_says_where_its_numbers_come_from():
    for name, path in packaged_scenarios().items():
        lines = path.read_text().splitlines() if "field" in name else []
        for i, line in enumerate(lines):
            if line.endswith(":") and not line.startswith((" ", "reference")):
                assert lines[i - 1].startswith("# "), f"{name}: {line}"

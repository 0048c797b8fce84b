"""Hashes that tell whether two scenarios, or parts of them, are the same."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from aerodrake.errors import file_at
from aerodrake.files import locate, read_bounded
from aerodrake.scenario import Scenario
from aerodrake.schema import as_mapping
from aerodrake.urdf import MAX_BYTES

PLANT_SECTIONS = ("vehicle", "flight", "arm", "rates", "model")
"""What decides the residual velocity, apart from noise, weather and what is off the model."""


def scenario_hash(scenario: Scenario) -> str:
    """Of everything that the scenario says but its name."""
    return digest({k: v for k, v in as_mapping(scenario).items() if k != "name"})


def plant_hash(scenario: Scenario) -> str:
    """Of the vehicle, with the robot's file as it is now, its controllers and its model.

    Raises:
        ScenarioError: if that file cannot be read.
    """
    sections = as_mapping(scenario)
    with file_at(scenario.source, "vehicle.robot"):
        content = read_bounded(locate(sections["vehicle"].pop("robot")), MAX_BYTES)
    return digest(
        {
            "robot": hashlib.sha256(content).hexdigest(),
            **{section: sections[section] for section in PLANT_SECTIONS},
        }
    )


def digest(data: dict[str, Any]) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of `data` as JSON."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]

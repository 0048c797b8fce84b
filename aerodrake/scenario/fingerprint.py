"""Hashes that tell whether two scenarios, or parts of them, are the same."""

from __future__ import annotations

import hashlib
import itertools
import json
from typing import Any

from aerodrake.scenario.faults import MPC_FAULTS, REFERENCE_FAULTS, LearnerFault
from aerodrake.scenario.inputs import MAX_BYTES
from aerodrake.scenario.schema import as_mapping
from aerodrake.scenario.sections import Scenario
from aerodrake.support.errors import file_at
from aerodrake.support.files import locate, read_bounded

PLANT_SECTIONS = ("vehicle", "flight", "arm", "rates", "model")
"""What decides the residual velocity, apart from noise, weather and what is off the model."""

COORDINATED = (
    "settle_s",
    "rates",
    "reference",
    "orientation",
    "vehicle",
    "faults",
    "flight",
    "model",
    "residual",
    "controller",
    "mpc",
    "clik",
    "allocation",
    "supervisor",
)
"""What the coordinator reads, of `faults` those of its own: a station that it is to fly agrees.

Of the rest it knows nothing: how long the flight is, and what the vehicle meets. The `seed` it
reads for an untrained network, which is its own.
"""

FILES = {
    "vehicle": "robot",
    "reference": "file",
    "orientation": "file",
    "residual": "checkpoint",
}
"""Keys of files, by section. What they say counts, not where they are."""


def scenario_hash(scenario: Scenario) -> str:
    """Of everything that the scenario says but its name."""
    return digest({k: v for k, v in as_mapping(scenario).items() if k != "name"})


def plant_hash(scenario: Scenario) -> str:
    """Of the vehicle, with the robot's file as it is now, its controllers and its model.

    Raises:
        ScenarioError: if that file cannot be read.
    """
    sections = as_mapping(scenario)
    robot = _hash_of_file(scenario, "vehicle.robot", sections["vehicle"].pop("robot"))
    return digest({"robot": robot, **{section: sections[section] for section in PLANT_SECTIONS}})


def coordinated(scenario: Scenario) -> dict[str, int]:
    """A number below 2^48 for each of `COORDINATED`, with its files as they are now.

    Raises:
        ScenarioError: if a file cannot be read.
    """
    sections = as_mapping(scenario)
    for section, key in FILES.items():
        if file := sections[section].get(key):
            sections[section][key] = _hash_of_file(scenario, f"{section}.{key}", file)
    faults = (*MPC_FAULTS, *REFERENCE_FAULTS, LearnerFault)
    kept = [isinstance(fault, faults) for fault in scenario.faults]
    sections["faults"] = list(itertools.compress(sections["faults"], kept))
    return {name: int(digest(sections[name])[:12], 16) for name in COORDINATED}


def digest(data: Any) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of `data` as JSON."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def _hash_of_file(scenario: Scenario, key: str, file: str) -> str:
    with file_at(scenario.source, key):
        return hashlib.sha256(read_bounded(locate(file), MAX_BYTES)).hexdigest()

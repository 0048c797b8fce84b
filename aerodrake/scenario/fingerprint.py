"""Hashes of scenarios and of their sections."""

import hashlib
import itertools
import json
from typing import Any

from aerodrake.scenario.faults import LearnerFault, MpcFault, ReferenceFault
from aerodrake.scenario.inputs import MAX_BYTES
from aerodrake.scenario.scenario import Scenario
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.errors import file_at
from aerodrake.support.files import locate, read_bounded

PLANT_SECTIONS = ("vehicle", "flight", "arm", "rates", "model")
"""Sections that determine the residual, except for noise, wind and model mismatch."""

STATION_SECTIONS = (
    *("duration", "physics", "sensors", "filter", "wind", "air", "actuation", "payload"),
    *("mismatch", "arm"),
)
"""Sections that the coordinator does not read."""

COORDINATED = tuple(
    key for key in as_mapping(Scenario()) if key not in ("name", "seed", *STATION_SECTIONS)
)
"""Sections that the coordinator reads; of `faults` only those of MPC, reference and learning.

A remote station must agree on them. The coordinator reads `seed` as well, but only to initialise
an untrained network.
"""

FILES = {"vehicle": "robot", "reference": "file", "orientation": "file", "residual": "checkpoint"}
"""Section -> its key that names a file. The hash is of the file's content, not of its path."""


def scenario_hash(scenario: Scenario) -> str:
    """Returns the hash of all keys except the name."""
    return digest({k: v for k, v in as_mapping(scenario).items() if k != "name"})


def plant_hash(scenario: Scenario) -> str:
    """Returns the hash of `PLANT_SECTIONS`, with the current content of the robot's file.

    Raises:
        ScenarioError: if the robot's file cannot be read.
    """
    sections = as_mapping(scenario)
    robot = _hash_of_file(scenario, "vehicle.robot", sections["vehicle"].pop("robot"))
    return digest({"robot": robot, **{section: sections[section] for section in PLANT_SECTIONS}})


def coordinated(scenario: Scenario) -> dict[str, int]:
    """Returns a hash below 2^48 for each of `COORDINATED`, with the current content of its files.

    Raises:
        ScenarioError: if a file cannot be read.
    """
    sections = as_mapping(scenario)
    for section, key in FILES.items():
        if file := sections[section].get(key):
            sections[section][key] = _hash_of_file(scenario, f"{section}.{key}", file)
    read = MpcFault | ReferenceFault | LearnerFault
    kept = [isinstance(fault, read) for fault in scenario.faults]
    sections["faults"] = list(itertools.compress(sections["faults"], kept))
    return {name: int(digest(sections[name])[:12], 16) for name in COORDINATED}


def digest(data: Any) -> str:
    """Returns the first 16 hexadecimal digits of the SHA-256 of `data` as JSON."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def _hash_of_file(scenario: Scenario, key: str, file: str) -> str:
    with file_at(scenario.source, key):
        return hashlib.sha256(read_bounded(locate(file), MAX_BYTES)).hexdigest()

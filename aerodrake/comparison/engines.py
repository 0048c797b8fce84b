"""One flight in both physics engines, and the differences between the two."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from aerodrake.flight.log import FlightLog
from aerodrake.scenario import Physics, Scenario
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import sourced

DRAKE, MUJOCO = "drake", "mujoco"

Differences = Mapping[str, Mapping[str, float]]
"""`mean` and `max` over time of the difference of each quantity, whose name ends in its unit."""

QUANTITIES = {
    "tool_m": ("tool's position", "mm", 1e3),
    "base_m": ("base's position", "mm", 1e3),
    "attitude_rad": ("base's attitude", "deg", 180 / np.pi),
    "joints_rad": ("joint angles, largest", "deg", 180 / np.pi),
    "thrust_n": ("rotor thrusts, largest", "N", 1.0),
}
"""Title, shown unit and factor to it of each quantity."""


def engine_variants(scenario: Scenario) -> dict[str, Scenario]:
    """Returns the scenario in each engine; with Drake the keys of MuJoCo are at their defaults.

    Raises:
        BadInput: if MuJoCo is not installed.
    """
    engines = {DRAKE: Physics(), MUJOCO: replace(scenario.physics, engine=MUJOCO)}
    variants = {name: replace(scenario, physics=physics) for name, physics in engines.items()}
    for variant in variants.values():
        with sourced(scenario.source):
            make_closed_loop(variant)
    return variants


def are_engines(names: Iterable[str]) -> bool:
    """Returns True if these are the names of `engine_variants`."""
    return list(names) == [DRAKE, MUJOCO]


def engine_differences(logs: Mapping[str, FlightLog]) -> Differences:
    """Returns the differences between both flights while both last; empty without one of them."""
    if DRAKE not in logs or MUJOCO not in logs:
        return {}
    ours, theirs = logs[DRAKE], logs[MUJOCO]
    both = min(len(ours.time_s), len(theirs.time_s))

    def difference(key: str) -> np.ndarray:
        return ours[key][:both] - theirs[key][:both]

    alike = np.abs(np.sum(ours["quaternion"][:both] * theirs["quaternion"][:both], axis=1))
    over_time = {
        "tool_m": np.linalg.norm(difference("p_E_m"), axis=1),
        "base_m": np.linalg.norm(difference("p_B_m"), axis=1),
        "attitude_rad": 2 * np.arccos(np.minimum(alike, 1.0)),
        "joints_rad": np.abs(difference("q_rad")).max(axis=1),
        "thrust_n": np.abs(difference("thrust_n")).max(axis=1),
    }
    return {
        name: {"mean": float(np.nanmean(values)), "max": float(np.nanmax(values))}
        for name, values in over_time.items()
    }


def difference_rows(differences: Differences) -> list[list[str]]:
    """Returns title, mean, maximum and unit of each quantity."""
    rows = []
    for name, values in differences.items():
        title, unit, factor = QUANTITIES[name]
        rows.append([title, *(f"{factor * values[key]:.3g}" for key in ("mean", "max")), unit])
    return rows


def difference_table(differences: Differences) -> str:
    """Returns the differences as text; empty if there are none."""
    if not differences:
        return ""
    rows = [["mujoco - drake", "mean", "max", ""], *difference_rows(differences)]
    return "\n".join(
        f"{t:<26}{mean:>10}{most:>10}  {unit}".rstrip() for t, mean, most, unit in rows
    )

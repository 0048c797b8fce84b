"""Data collection: stages flown in parallel, kept in files, and never flown twice."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from aerodrake.learning.dataset import load_samples, save_samples
from aerodrake.learning.stages import Stage, fly_stage
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import feature_names
from aerodrake.model.residual.samples import Samples, residual_samples
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import digest, plant_hash
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.errors import BadInput, ProcessDied
from aerodrake.support.processes import run_parallel

FORMAT = 2
"""Version of the files and of how stages are flown."""


def collect(
    scenario: Scenario,
    model: EquivalentModel,
    stages: Sequence[Stage],
    folder: Path,
    jobs: int,
    progress: Callable[[Stage], None] = lambda stage: None,
) -> dict[str, Samples]:
    """The samples of all stages, by name: read where there is a file, else flown.

    A stage's file is named after the stage and a hash of all that determines it,
    so that those of another scenario stay where they are and are not used.

    Args:
        scenario: Whose station is flown.
        model: Whose residual the targets are.
        stages: With names of their own.
        folder: Of the files; exists.
        jobs: Stages flown at a time.
        progress: Called with each stage when it is there.

    Raises:
        BadInput: if a file holds something else, which is left as it is; or if a
            stage cannot be flown.
        ProcessDied: if the process of a stage did; stages flown before stay.
    """
    flights: dict[str, Samples] = {}
    files = {stage.name: describe(scenario, stage) for stage in stages}
    missing = []
    for stage in stages:
        metadata = files[stage.name]
        path = place(folder, metadata)
        if path.exists():
            samples = round(stage.duration_s / model.dt) - 1
            size = (samples, len(feature_names(model.joints)))
            flights[stage.name] = load_samples(path, metadata, size)
            progress(stage)
        else:
            missing.append(stage)
    for i, result in run_parallel(partial(_fly, scenario, model), missing, jobs):
        stage = missing[i]
        if isinstance(result, BadInput):
            raise result
        if isinstance(result, ProcessDied):
            raise ProcessDied(f"stage {stage.name}: {result}")
        if isinstance(result, Exception):
            raise BadInput(
                scenario.source, "", f"stage {stage.name} could not be flown: {result}"
            ) from result
        metadata = files[stage.name]
        save_samples(place(folder, metadata), result, metadata)
        flights[stage.name] = result
        progress(stage)
    return {stage.name: flights[stage.name] for stage in stages}


def describe(scenario: Scenario, stage: Stage) -> dict[str, Any]:
    """What a stage's file says of itself, down to all that determines its samples."""
    motion = {f.name: getattr(stage, f.name) for f in dataclasses.fields(stage)}
    joints = len(scenario.vehicle.working_rad)
    return {
        "format": FORMAT,
        "version": version("aerodrake"),
        "stage": {**motion, **{k: as_mapping(motion[k]) for k in ("base", "wind", "payload")}},
        "sensors": as_mapping(scenario.sensors),
        "mismatch": as_mapping(scenario.mismatch),
        "learning_space_m": list(scenario.allocation.learning_space_m),
        "flight_interface": scenario.flight.interface,
        "plant_hash": plant_hash(scenario),
        "features": feature_names(joints),
        "targets": ["v_x_m_s", "v_y_m_s", "v_z_m_s"],
        "period_s": scenario.rates.mpc_period_s,
    }


def place(folder: Path, metadata: dict[str, Any]) -> Path:
    """The file of a stage: `folder`/NAME-HASH.npz."""
    return folder / f"{metadata['stage']['name']}-{digest(metadata)}.npz"


def _fly(scenario: Scenario, model: EquivalentModel, stage: Stage) -> Samples:
    flown = fly_stage(scenario, stage)
    return residual_samples(
        model,
        flown.state,
        flown.base_setpoint,
        flown.joint_setpoint,
        flown.specific_thrust,
        flown.external_acceleration,
        flown.disturbance,
    )

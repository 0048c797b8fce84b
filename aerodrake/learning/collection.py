"""Data collection: runs flown in parallel, stored in files and reused."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from aerodrake.learning.collection_runs import CollectionRun, fly_run
from aerodrake.learning.dataset import load_samples, save_samples
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import feature_names
from aerodrake.model.residual.samples import Samples, residual_samples
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import digest, plant_hash
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.errors import BadInput, ProcessDied
from aerodrake.support.processes import run_parallel
from aerodrake.support.version import __version__

FORMAT = 2
"""Version of the files' format, which calls a collection run a stage, and of the flights."""


def collect(
    scenario: Scenario,
    model: EquivalentModel,
    runs: Sequence[CollectionRun],
    folder: Path,
    jobs: int,
    progress: Callable[[CollectionRun], None] = lambda run: None,
) -> dict[str, Samples]:
    """Returns the samples of all runs, by name: from a file if it exists, else from a flight.

    A file is named after its run and a hash of all that determines the samples. Files of
    another scenario are therefore neither used nor replaced.

    Args:
        scenario: The scenario whose station is flown.
        model: The model whose residual is learned.
        runs: Runs with distinct names.
        folder: Folder of the files; it exists.
        jobs: Number of runs flown in parallel.
        progress: Called with each run when its samples are available.

    Raises:
        BadInput: if a file has another content, which is not changed; or if a run cannot be flown.
        ProcessDied: if the process of a run died; the files of completed runs remain.
    """
    flights: dict[str, Samples] = {}
    missing = []
    for run in runs:
        metadata = describe(scenario, run)
        path = dataset_path(folder, metadata)
        if path.exists():
            size = round(run.duration_s / model.dt) - 1, len(feature_names(model.joints))
            try:
                flights[run.name] = load_samples(path, metadata, size)
            except BadInput as error:
                remedy = f"delete the file, and collection run {run.name} is flown again"
                raise BadInput(path, "", f"{error.args[2]}; {remedy}") from None
            progress(run)
        else:
            missing.append((run, path, metadata))
    fly = partial(_fly, scenario, model)
    for i, result in run_parallel(fly, [run for run, _, _ in missing], jobs):
        run, path, metadata = missing[i]
        if isinstance(result, BadInput):
            raise result
        if isinstance(result, ProcessDied):
            raise ProcessDied(f"collection run {run.name}: {result}")
        if isinstance(result, Exception):
            message = f"collection run {run.name} could not be flown: {result}"
            raise BadInput(scenario.source, "", message) from result
        save_samples(path, result, metadata)
        flights[run.name] = result
        progress(run)
    return {run.name: flights[run.name] for run in runs}


def describe(scenario: Scenario, run: CollectionRun) -> dict[str, Any]:
    """Returns the metadata of a run's file: all that determines its samples."""
    sections = {"base": run.base, "wind": run.wind, "payload": run.payload}
    return {
        "format": FORMAT,
        "version": __version__,
        "stage": {**vars(run), **{name: as_mapping(part) for name, part in sections.items()}},
        "sensors": as_mapping(scenario.sensors),
        "mismatch": as_mapping(scenario.mismatch),
        "learning_space_m": list(scenario.allocation.learning_space_m),
        "flight_interface": scenario.flight.interface,
        "plant_hash": plant_hash(scenario),
        "features": feature_names(len(scenario.vehicle.working_rad)),
        "targets": ["v_x_m_s", "v_y_m_s", "v_z_m_s"],
        "period_s": scenario.rates.mpc_period_s,
    }


def dataset_path(folder: Path, metadata: dict[str, Any]) -> Path:
    """Returns the path of a run's file, NAME-HASH.npz."""
    return folder / f"{metadata['stage']['name']}-{digest(metadata)}.npz"


def _fly(scenario: Scenario, model: EquivalentModel, run: CollectionRun) -> Samples:
    return residual_samples(model, fly_run(scenario, run))

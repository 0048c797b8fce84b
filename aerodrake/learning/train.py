"""`aerodrake train`: collects data, trains the residual network and judges it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
from tqdm import tqdm

from aerodrake.flight.summary import to_json
from aerodrake.learning.collection import collect
from aerodrake.learning.evaluation import Evaluation, evaluate
from aerodrake.learning.report import plot_training
from aerodrake.learning.stages import Stage
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.checkpoint import Provenance, load, save
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.training import Training, train
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import plant_hash, scenario_hash
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.support.files import write_atomically
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.scratch import scratch_folder
from aerodrake.support.threads import single_thread

CHECKPOINT, LOG, FIGURE, STAGES = "network.pt", "training.json", "training.png", "stages"


def train_scenario(
    scenario: Scenario,
    stages: Sequence[Stage],
    config: Training,
    folder: Path,
    jobs: int,
    quiet: bool = False,
) -> Evaluation:
    """Flies the stages that are not in `folder` yet, trains a network and writes it there.

    The folder then holds `stages/`, the samples; `network.pt`, the checkpoint;
    `training.json`, its losses and errors; and `training.png`. Interrupted, it
    goes on where it stopped when it is called again.

    Args:
        scenario: Its vehicle, flight controller, model, residual section and seed.
        stages: At least one of each role.
        config: How the network is trained.
        folder: Created if missing.
        jobs: Stages flown at a time.
        quiet: Whether to show no progress.

    Raises:
        BadInput: if the scenario cannot be trained for, or `folder` holds
            something else, which is left as it is.
    """
    vehicle = VehicleModel.load(scenario)
    if scenario.model.kind == "integral":
        raise ScenarioError(
            scenario.source,
            "model.kind",
            "expected flight, velocity_aware, paper or exact; the integral model has no residual",
        )
    model = EquivalentModel.of(scenario, vehicle.joints)
    gain = model.C[model.base_velocity].diagonal()
    _prepare(folder, vehicle.joints)

    total = sum(stage.duration_s for stage in stages)
    with tqdm(total=total, desc="stages", unit="s", disable=quiet) as bar:
        flights = collect(
            scenario,
            model,
            stages,
            folder / STAGES,
            jobs,
            progress=lambda stage: bar.update(stage.duration_s),
        )
    training, validation = (
        [flights[stage.name] for stage in stages if stage.role == role]
        for role in ("training", "validation")
    )
    with single_thread(), tqdm(total=config.epochs, desc="epochs", disable=quiet) as bar:

        def advance(training_loss: float, validation_loss: float) -> None:
            bar.set_postfix_str(f"loss {training_loss:.3g}, validation {validation_loss:.3g}")
            bar.update()

        trained = train(training, validation, gain, vehicle.joints, scenario.seed, config, advance)
        if not np.isfinite(trained.validation_loss).any():
            raise BadInput(
                folder / STAGES,
                "",
                "expected samples to which a network can be fitted; its loss is not finite",
            )
        held_out = [stage for stage in stages if stage.role == "held_out"]
        evaluation = evaluate(
            held_out,
            flights,
            trained.network,
            gain,
            scenario.residual,
            LinearResidual.fit(training, 0.0),
            LinearResidual.fit_ridge(training, validation),
        )
        features, targets = flights[held_out[-1].twin or held_out[-1].name]
        delta = trained.network.phi(features) @ trained.network.last_layer().T
    provenance = Provenance(
        version("aerodrake"),
        scenario.flight.interface,
        plant_hash(scenario),
        scenario_hash(scenario),
    )
    log = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "version": version("aerodrake"),
        "stages": [stage.name for stage in stages if stage.role != "held_out"],
        "best_epoch": trained.best_epoch,
        "training_loss": trained.training_loss.tolist(),
        "validation_loss": trained.validation_loss.tolist(),
        **evaluation.as_mapping(),
    }
    title = f"{scenario.name}: held-out flight {held_out[-1].twin or held_out[-1].name}"
    try:
        with deferred_interrupts(), scratch_folder(folder) as scratch:
            plot_training(trained, delta, targets / gain, model.dt, title, scratch / FIGURE)
            save(folder / CHECKPOINT, trained.network, provenance)
            write_atomically(folder / LOG, to_json(log).encode())
            os.replace(scratch / FIGURE, folder / FIGURE)
    except OSError as error:
        raise BadInput("--out", "", f"cannot write {folder}: {error.strerror}") from None
    return evaluation


def _prepare(folder: Path, joints: int) -> None:
    """Makes the folder, unless something in it is not of an earlier training."""
    known = {CHECKPOINT, LOG, FIGURE, STAGES}
    try:
        if folder.exists():
            names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
            # Killed, it may have left a network without a figure, but then beside its stages.
            has_network = CHECKPOINT in names
            is_whole = has_network == (FIGURE in names) or has_network and STAGES in names
            if names - known or not is_whole:
                raise BadInput(
                    "--out", "", f"{folder} holds files that are not of an earlier training"
                )
        (folder / STAGES).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput("--out", "", f"cannot write {folder}: {reason}") from None
    for name in (LOG, FIGURE):
        if (folder / name).is_dir():
            raise BadInput("--out", "", f"expected a file, but {folder / name} is a folder")
    if (folder / CHECKPOINT).exists():
        load(folder / CHECKPOINT, joints)

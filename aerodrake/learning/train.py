"""Data collection, training and evaluation of the residual network."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from aerodrake.flight.summary import to_json
from aerodrake.learning.collection import collect
from aerodrake.learning.collection_runs import CollectionRun
from aerodrake.learning.evaluation import Candidates, NetworkEvaluation, evaluate
from aerodrake.learning.report import DeltaFlight, plot_training
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.checkpoint import Provenance, load, save
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.model.residual.training import TrainingConfig, TrainingData, TrainingResult, train
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.reports.drawing import drawing
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import plant_hash, scenario_hash
from aerodrake.support.errors import BadInput, ScenarioError, writing
from aerodrake.support.files import write_atomically
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.threads import single_thread
from aerodrake.support.version import __version__

CHECKPOINT, LOG, FIGURE, DATA = "network.pt", "training.json", "training.png", "stages"
"""Files of a training; the folder `stages` contains the samples of the collection runs."""


def train_scenario(
    scenario: Scenario,
    runs: Sequence[CollectionRun],
    config: TrainingConfig,
    folder: Path,
    jobs: int,
    quiet: bool = False,
) -> NetworkEvaluation:
    """Flies the runs that are not in `folder` yet, trains a network and writes it there.

    The folder then contains `stages/`, the samples; `network.pt`, the checkpoint;
    `training.json`, losses and errors; and `training.png`. An interrupted training
    continues when it is called again.

    Args:
        scenario: Vehicle, flight controller, model, residual section and seed.
        runs: At least one of each role.
        config: Settings of the training.
        folder: Created if missing.
        jobs: Number of runs flown in parallel.
        quiet: True to show no progress.

    Raises:
        BadInput: if the scenario has no residual to learn, or `folder` contains other files,
            which are not changed.
    """
    vehicle = VehicleModel.load(scenario)
    if scenario.model.kind == "integral":
        kinds = "flight, velocity_aware, paper or exact; the integral model has no residual"
        raise ScenarioError(scenario.source, "model.kind", f"expected {kinds}")
    model = EquivalentModel.of(scenario, vehicle.joints)
    _prepare(folder, vehicle.joints)
    total = sum(run.duration_s for run in runs)
    with tqdm(total=total, desc="collection runs", unit="s", disable=quiet) as bar:
        flights = collect(
            scenario, model, runs, folder / DATA, jobs, lambda run: bar.update(run.duration_s)
        )
    training = [flights[run.name] for run in runs if run.role == "training"]
    validation = [flights[run.name] for run in runs if run.role == "validation"]
    held_out = [run for run in runs if run.role == "held_out"]
    gain = model.residual_gain
    data = TrainingData(training, validation, gain, vehicle.joints)
    with single_thread():
        result = _train(data, scenario.seed, config, folder, quiet)
        theta = gain[:, None] * result.network.last_layer()
        learner = OnlineLearner(scenario.residual, theta)
        linear = LinearResidual.fit(training, 0.0)
        ridge = LinearResidual.fit_ridge(training, validation)
        network = result.network
        evaluation = evaluate(held_out, flights, Candidates(network, learner, linear, ridge))
        calm = held_out[-1].twin or held_out[-1].name
        features, targets = flights[calm]
        title = f"{scenario.name}: held-out flight {calm}"
        estimated = network.phi(features) @ network.last_layer().T
        delta = DeltaFlight(title, model.dt, model.residual.unit, estimated, targets / gain)
    log = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "version": __version__,
        "stages": [run.name for run in runs if run.role != "held_out"],
        "delta": f"{model.residual.name}, {model.residual.unit}",
        "best_epoch": result.best_epoch,
        "training_loss": result.training_loss.tolist(),
        "validation_loss": result.validation_loss.tolist(),
        **evaluation.as_mapping(),
    }
    _write(folder, scenario, result, delta, log)
    return evaluation


def _train(
    data: TrainingData, seed: int, config: TrainingConfig, folder: Path, quiet: bool
) -> TrainingResult:
    """Trains with a progress bar; `folder` is named in the error if no loss is finite."""
    with tqdm(total=config.epochs, desc="epochs", disable=quiet) as bar:

        def advance(training_loss: float, validation_loss: float) -> None:
            bar.set_postfix_str(f"loss {training_loss:.3g}, validation {validation_loss:.3g}")
            bar.update()

        result = train(data, seed, config, advance)
    if not np.isfinite(result.validation_loss).any():
        message = "expected samples to which a network can be fitted; its loss is not finite"
        raise BadInput(folder / DATA, "", message)
    return result


def _write(
    folder: Path,
    scenario: Scenario,
    result: TrainingResult,
    delta: DeltaFlight,
    log: dict[str, Any],
) -> None:
    """Writes checkpoint, log and figure."""
    hashes = plant_hash(scenario), scenario_hash(scenario)
    interface = scenario.flight.interface
    provenance = Provenance(__version__, interface, delta.unit, *hashes)
    with deferred_interrupts(), writing(folder):
        save(folder / CHECKPOINT, result.network, provenance)
        write_atomically(folder / LOG, to_json(log).encode())
        with drawing(folder / FIGURE):
            plot_training(result, delta, folder / FIGURE)


def _prepare(folder: Path, joints: int) -> None:
    """Creates the folder; refuses one with files that are not of an earlier training."""
    with writing(folder):
        if folder.exists():
            names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
            has_network, has_figure = CHECKPOINT in names, FIGURE in names
            # A killed training leaves a network without a figure, but with its samples.
            is_interrupted = has_network and DATA in names
            is_incomplete = has_network != has_figure and not is_interrupted
            if is_incomplete or names - {CHECKPOINT, LOG, FIGURE, DATA}:
                raise BadInput(folder, "", "holds files that are not of an earlier training")
        (folder / DATA).mkdir(parents=True, exist_ok=True)
    for name in (LOG, FIGURE):
        if (folder / name).is_dir():
            raise BadInput(folder / name, "", "expected a file, got a folder")
    if (folder / CHECKPOINT).exists():
        try:
            load(folder / CHECKPOINT, joints)
        except BadInput as error:
            remedy = "delete the file, or train in another folder"
            raise BadInput(folder / CHECKPOINT, "", f"{error.args[2]}; {remedy}") from None

"""Training in a folder: its files, and what refuses or resumes it."""

import dataclasses
import json
import shutil

import numpy as np
import pytest

from aerodrake.learning import collection
from aerodrake.learning.collection_runs import CollectionRun, circle, with_disturbances
from aerodrake.learning.evaluation import METHODS
from aerodrake.learning.train import train_scenario
from aerodrake.model.residual.checkpoint import load
from aerodrake.model.residual.training import TrainingConfig
from aerodrake.scenario import Model
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput, ProcessDied
from tests.in_this_process import in_this_process

RUNS = [
    CollectionRun("one", "training", 3.0, 5.0, 0.0, circle(0.1, 0.1, 0.3), turn_s=6.0),
    CollectionRun("two", "validation", 3.0, 6.0, 0.5, circle(0.1, -0.12, 0.3), turn_s=6.0),
    *with_disturbances(CollectionRun("three", "held_out", 2.0, 4.0, 0.2), 0.0, 1)[::3],
]
TRAINING = TrainingConfig(epochs=4, batch=64)


def train(folder, scenario, runs=RUNS):
    return train_scenario(scenario, runs, TRAINING, folder, jobs=2, quiet=True)


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("clover_paper")


@pytest.fixture(scope="module")
def trained(tmp_path_factory, scenario):
    folder = tmp_path_factory.mktemp("train") / "new" / "folder"
    return folder, train(folder, scenario)


def content(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def grounded(monkeypatch):
    """Replaces the flights: none takes place."""
    monkeypatch.setattr(collection, "run_parallel", lambda function, items, jobs: iter([]))
    return monkeypatch


def test_all_files_are_written(trained, scenario):
    folder, evaluation = trained
    assert {path.name for path in folder.iterdir()} == {
        *("network.pt", "training.json", "training.png", "stages")
    }
    assert len(list((folder / "stages").iterdir())) == len(RUNS)
    network, provenance = load(folder / "network.pt", 6)
    assert (provenance.flight_interface, provenance.delta_unit) == ("position", "m/s")
    assert (folder / "network.pt").stat().st_size < 100_000
    log = json.loads((folder / "training.json").read_text())
    assert log["delta"] == "residual velocity, m/s"
    assert len(log["training_loss"]) == len(log["validation_loss"]) == 4
    assert log["rmse_m_s"]["three"].keys() == set(METHODS)
    assert log["rmse_m_s"]["three_payload"] == dict(evaluation.rmse[1])


def test_a_completed_run_is_not_flown_again(trained, scenario, grounded):
    folder, _ = trained
    before = content(folder)
    train(folder, scenario)
    assert content(folder) == before  # Trained again from the same files: bit for bit.


def test_another_scenario_uses_none_of_the_samples(trained, scenario, grounded):
    other = dataclasses.replace(scenario, model=Model(kind="paper", k_b=(2.0, 2.0, 2.0)))
    flown = []
    grounded.setattr(
        collection, "run_parallel", lambda function, items, jobs: flown.extend(items) or iter([])
    )
    with pytest.raises(KeyError):  # Since nothing was flown.
        train(trained[0], other)
    assert flown == RUNS


@pytest.mark.parametrize("name", ["stages/one-*.npz", "network.pt"])
def test_invalid_files_are_refused_and_kept(trained, scenario, grounded, name):
    folder, _ = trained
    path = next(folder.glob(name))
    good = path.read_bytes()
    path.write_bytes(good[:1000])
    before = content(folder)
    try:
        with pytest.raises(BadInput, match="of aerodrake"):
            train(folder, scenario)
        assert content(folder) == before
    finally:
        path.write_bytes(good)


def test_a_folder_with_other_files_is_refused_and_not_changed(tmp_path, scenario):
    (tmp_path / "thesis.tex").write_text("x")
    with pytest.raises(BadInput, match="not of an earlier training"):
        train(tmp_path, scenario)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(BadInput, match="cannot be written"):
        train(tmp_path / "thesis.tex", scenario)


@pytest.mark.parametrize("remaining", [["network.pt"], ["network.pt", "training.json"]])
def test_a_training_killed_while_writing_resumes(trained, scenario, grounded, tmp_path, remaining):
    folder = tmp_path / "copy"
    shutil.copytree(trained[0], folder)
    for name in {"network.pt", "training.json", "training.png"} - {*remaining}:
        (folder / name).unlink()
    train(folder, scenario)
    assert {path.name for path in folder.iterdir()} == {path.name for path in trained[0].iterdir()}


def test_another_network_is_not_replaced(trained, scenario, tmp_path, grounded):
    shutil.copy(trained[0] / "network.pt", tmp_path)
    with pytest.raises(BadInput, match="not of an earlier training"):
        train(tmp_path, scenario)


def test_a_process_that_died_is_named(tmp_path, scenario, grounded):
    grounded.setattr(
        collection,
        "run_parallel",
        lambda function, items, jobs: iter([(1, ProcessDied("its process died of SIGKILL"))]),
    )
    with pytest.raises(ProcessDied, match="^collection run two: its process died of SIGKILL$"):
        train(tmp_path, scenario)


def test_the_integral_model_has_no_residual(tmp_path, scenario):
    integral = dataclasses.replace(scenario, model=Model(kind="integral"))
    with pytest.raises(BadInput, match="model.kind"):
        train(tmp_path, integral)


def test_a_run_that_cannot_be_flown_is_named_and_completed_runs_are_kept(
    tmp_path, scenario, monkeypatch
):
    monkeypatch.setattr(collection, "run_parallel", in_this_process)
    wild = dataclasses.replace(RUNS[0], name="wild", lap_s=1.0)
    with pytest.raises(
        BadInput, match="collection run wild could not be flown: the joints' limits"
    ):
        train(tmp_path, scenario, [wild, *RUNS[:1]])
    (path,) = (tmp_path / "stages").iterdir()
    with np.load(path) as file:
        assert set(file.files) == {"features", "targets", "metadata"}


def test_samples_that_cannot_be_fitted_keep_the_earlier_network(
    trained, scenario, tmp_path, grounded
):
    folder = tmp_path / "copy"
    shutil.copytree(trained[0], folder)
    (path,) = (folder / "stages").glob("one-*.npz")
    with np.load(path) as file:
        arrays = dict(file)
    arrays["targets"][3, 0] = 1e300
    with path.open("wb") as file:
        np.savez(file, **arrays)
    before = content(folder)
    with (
        pytest.raises(BadInput, match="stages: expected samples to which a network can be fitted"),
        np.errstate(all="ignore"),
    ):
        train(folder, scenario)
    assert content(folder) == before


def test_another_figure_is_not_replaced(scenario, tmp_path, grounded):
    (tmp_path / "training.png").write_text("mine")
    with pytest.raises(BadInput, match="not of an earlier training"):
        train(tmp_path, scenario)
    assert (tmp_path / "training.png").read_text() == "mine"


def test_a_damaged_network_is_refused_with_the_way_out(scenario, tmp_path, grounded):
    (tmp_path / "stages").mkdir()
    (tmp_path / "network.pt").write_bytes(b"PK")
    remedy = "got another or a truncated file; delete the file, or train in another folder"
    with pytest.raises(BadInput, match=f"network.pt: expected a checkpoint .*, {remedy}$"):
        train(tmp_path, scenario)
    assert (tmp_path / "network.pt").read_bytes() == b"PK"

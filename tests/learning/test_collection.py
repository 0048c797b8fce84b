"""Files of the samples of runs: their names, and damaged ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerodrake.learning.collection import collect, dataset_path, describe
from aerodrake.learning.collection_runs import quick_runs
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.scenario import Mismatch, Mpc, Sensors
from aerodrake.support.errors import BadInput


@pytest.mark.parametrize(
    ("change", "is_distinct"),
    [
        ({"sensors": Sensors(base_delay_s=0.01)}, True),
        ({"mismatch": Mismatch(rotor_lag_scale=1.2)}, True),
        ({"mpc": Mpc(horizon=7)}, False),
    ],
)
def test_samples_of_another_station_have_another_file(scenario, change, is_distinct):
    run, *_ = quick_runs()
    path, other = (
        dataset_path(Path("data"), describe(each, run))
        for each in (scenario, replace(scenario, **change))
    )
    assert (path != other) == is_distinct
    assert path.parent == Path("data") and path.name.startswith(f"{run.name}-")


def empty(path):
    path.touch()


def truncated(path):
    np.savez(path, features=np.zeros((99, 30)), targets=np.zeros((99, 3)), metadata=np.array("{}"))
    path.write_bytes(path.read_bytes()[:1000])


def other_arrays(path):
    np.savez(path, features=np.zeros((99, 30)))


def single_array(path):
    with path.open("wb") as file:
        np.save(file, np.zeros(3))


def other_version(path):
    np.savez(path, features=np.zeros((99, 30)), targets=np.zeros((99, 3)), metadata=np.array("{}"))


def folder(path):
    path.mkdir()


@pytest.mark.parametrize(
    ("write", "got"),
    [
        (empty, "got an empty file"),
        (truncated, "got another or a truncated file"),
        (single_array, "got another or a truncated file"),
        (other_arrays, "with the arrays features, targets, metadata, got others"),
        (other_version, "of this collection run and scenario, got another"),
        (folder, "expected a readable file: Is a directory"),
    ],
)
def test_a_damaged_file_is_refused_with_the_way_out(scenario, tmp_path, write, got):
    """Before any flight, and without a change to the file."""
    run, other, *_ = quick_runs()
    path = dataset_path(tmp_path, describe(scenario, other))
    write(path)
    with pytest.raises(BadInput) as error:
        collect(scenario, EquivalentModel.of(scenario, 6), [run, other], tmp_path, 1)
    remedy = f"delete the file, and collection run {other.name} is flown again"
    assert str(error.value).startswith(f"{path}: expected ")
    assert str(error.value).endswith(f"{got}; {remedy}")
    assert list(tmp_path.iterdir()) == [path]

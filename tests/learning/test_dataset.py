"""Files of samples, and defects that are refused."""

import io
import json
import pickle
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.learning import dataset
from aerodrake.learning.dataset import load_samples, save_samples
from aerodrake.support.errors import BadInput

METADATA = {"stage": {"name": "x", "lap_s": 0.1}, "format": 1}
SIZE = (50, 7)


@pytest.fixture
def samples():
    generator = np.random.default_rng(0)
    return generator.normal(size=SIZE), generator.normal(size=(50, 3))


@pytest.fixture
def path(tmp_path, samples):
    path = tmp_path / "x.npz"
    save_samples(path, samples, METADATA)
    return path


def test_saved_samples_are_loaded_and_no_other_file_is_left(path, samples):
    features, targets = load_samples(path, METADATA, SIZE)
    assert np.array_equal(features, samples[0]) and np.array_equal(targets, samples[1])
    assert [p.name for p in path.parent.iterdir()] == ["x.npz"]


def test_numpy_and_json_read_a_dataset(path):
    with np.load(path) as file:
        assert json.loads(file["metadata"].item()) == METADATA


def test_the_same_samples_give_the_same_bytes(path, tmp_path, samples):
    save_samples(tmp_path / "y.npz", samples, METADATA)
    with zipfile.ZipFile(path) as one, zipfile.ZipFile(tmp_path / "y.npz") as other:
        assert all(one.read(name) == other.read(name) for name in one.namelist())


def write(path, **arrays):
    np.savez(path, **arrays)


def truncated(path, arrays):
    path.write_bytes(path.read_bytes()[:-200])


def foreign(path, arrays):
    path.write_text("t,x,y,z\n")


def missing(path, arrays):
    path.unlink()


def other_arrays(path, arrays):
    write(path, features=arrays[0], metadata=np.array(json.dumps(METADATA)))


def with_(**changes):
    def change(path, arrays):
        all_ = {"features": arrays[0], "targets": arrays[1]}
        write(path, **{**all_, "metadata": np.array(json.dumps(METADATA)), **changes})

    return change


def compressed(path, arrays):
    np.savez_compressed(
        path, features=arrays[0], targets=arrays[1], metadata=np.array(json.dumps(METADATA))
    )


class Bomb:
    def __reduce__(self):
        return (pytest.fail, ("executed",))


def malicious(path, arrays):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "|O", "fortran_order": False, "shape": (1,)}
    )
    with zipfile.ZipFile(path, "w") as file:
        for name in ("features", "targets", "metadata"):
            file.writestr(f"{name}.npy", header.getvalue() + pickle.dumps(Bomb()))


def enormous_header(path, arrays):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**15, 7)}
    )
    with zipfile.ZipFile(path, "w") as file:
        for name in ("features", "targets", "metadata"):
            file.writestr(f"{name}.npy", header.getvalue())


NAN = np.full(SIZE, np.nan)


@pytest.mark.parametrize(
    "defect, message",
    [
        (missing, "readable file"),
        (truncated, "dataset of aerodrake"),
        (foreign, "dataset of aerodrake"),
        (malicious, "dataset of aerodrake"),
        (enormous_header, "dataset of aerodrake"),
        (compressed, "dataset of aerodrake"),
        (other_arrays, "dataset of aerodrake"),
        (with_(metadata=np.array("{")), "dataset of aerodrake"),
        (with_(metadata=np.array('{"format": 2}')), "of this collection run and scenario"),
        (with_(features=np.zeros((50, 6))), r"features to be \[50, 7\]"),
        (with_(targets=np.zeros((49, 3))), r"targets to be \[50, 3\]"),
        (with_(features=np.zeros(SIZE, np.float32)), "float64"),
        (with_(features=NAN), "features to be finite"),
        (with_(targets=np.full((50, 3), np.inf)), "targets to be finite"),
    ],
)
def test_any_other_file_is_bad_input_in_one_line(path, samples, defect, message):
    defect(path, samples)
    before = path.read_bytes() if path.exists() else None
    with pytest.raises(BadInput, match=message) as error:
        load_samples(path, METADATA, SIZE)
    assert "\n" not in str(error.value) and str(path) in str(error.value)
    assert (path.read_bytes() if path.exists() else None) == before


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_no_flipped_bit_changes_the_samples(tmp_path_factory, data):
    samples = np.arange(14.0).reshape(2, 7), np.ones((2, 3))
    path = tmp_path_factory.getbasetemp() / "flipped.npz"
    save_samples(path, samples, METADATA)
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(content)
    try:
        read = load_samples(path, METADATA, (2, 7))
    except BadInput:
        return
    assert all(map(np.array_equal, read, samples))


def test_a_file_above_the_limit_is_not_read(path, monkeypatch):
    monkeypatch.setattr(dataset, "MAX_BYTES", 100)
    with pytest.raises(BadInput, match="at most 100 bytes"):
        load_samples(path, METADATA, SIZE)


def test_a_path_that_cannot_be_written_is_bad_input(tmp_path, samples):
    with pytest.raises(BadInput, match="cannot be written"):
        save_samples(tmp_path / "none" / "x.npz", samples, METADATA)

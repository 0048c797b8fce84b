"""Checkpoint files, and defects that are refused."""

import dataclasses
import io
import zipfile

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.model.residual.checkpoint import (
    FORMAT,
    MAX_BYTES,
    Provenance,
    load,
    save,
)
from aerodrake.model.residual.features import feature_names
from aerodrake.model.residual.network import FeatureScaler, ResidualNetwork
from aerodrake.support.errors import BadInput

JOINTS = 6
PROVENANCE = Provenance("0.1.0", "trajectory", "m/s^2", "abc", "def")


def trained(joints: int = JOINTS) -> ResidualNetwork:
    """Returns a network without zeros, with a random scaler."""
    rng = np.random.default_rng(3)
    size = len(feature_names(joints))
    scaler = FeatureScaler(rng.normal(size=size), rng.uniform(0.1, 2, size))
    network = ResidualNetwork(joints, scaler, seed=4)
    with torch.no_grad():
        network.last.weight.copy_(torch.tensor(rng.normal(size=(3, 32))))
        network.last.bias.copy_(torch.tensor(rng.normal(size=3)))
    return network


def test_checkpoint_round_trip(tmp_path):
    network = trained()
    save(tmp_path / "a.pt", network, PROVENANCE)
    loaded, metadata = load(tmp_path / "a.pt", JOINTS)

    assert metadata == PROVENANCE
    for name, tensor in network.state_dict().items():
        assert torch.equal(tensor, loaded.state_dict()[name]), name
    save(tmp_path / "b.pt", loaded, metadata)
    assert (tmp_path / "a.pt").read_bytes() == (tmp_path / "b.pt").read_bytes()
    assert {p.name for p in tmp_path.iterdir()} == {"a.pt", "b.pt"}


def test_a_failed_save_keeps_the_earlier_file(tmp_path, monkeypatch):
    path = tmp_path / "a.pt"
    path.write_bytes(b"before")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(BadInput, match=r"a\.pt: .*No space left"):
        save(path, trained(), PROVENANCE)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("where", ["missing/a.pt", "file/a.pt"])
def test_save_to_a_path_that_cannot_be_written(tmp_path, where):
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match="cannot be written"):
        save(tmp_path / where, trained(), PROVENANCE)


@pytest.fixture
def checkpoint(tmp_path):
    """Returns a function that writes a checkpoint after a change to its mapping."""

    def write(change):
        path = tmp_path / "network.pt"
        save(path, trained(), PROVENANCE)
        data = torch.load(path, weights_only=True)
        change(data)
        torch.save(data, path)
        return path

    return write


def test_networks_of_format_1_are_in_m_s(checkpoint):
    def lacks_unit(data, version):
        data["format"] = version
        del data["metadata"]["delta_unit"]

    _, provenance = load(checkpoint(lambda data: lacks_unit(data, 1)), JOINTS)
    assert provenance == dataclasses.replace(PROVENANCE, delta_unit="m/s")
    rejects(checkpoint(lambda data: lacks_unit(data, FORMAT)), "expected a checkpoint of aerodrake")


def rejects(path, message, joints=JOINTS):
    with pytest.raises(BadInput, match=message) as error:
        load(path, joints)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{path}: ")


def test_missing_file(tmp_path):
    rejects(tmp_path / "none.pt", "expected a readable file: No such file")
    rejects(tmp_path, "expected a readable file: Is a directory")


@pytest.mark.parametrize("content", [b"", b"text", b"PK\x03\x04", b"\x80\x02}q\x00."])
def test_not_a_checkpoint(tmp_path, content):
    path = tmp_path / "network.pt"
    path.write_bytes(content)
    rejects(path, "expected a checkpoint of aerodrake")


def test_truncated(tmp_path):
    path = tmp_path / "network.pt"
    save(path, trained(), PROVENANCE)
    content = path.read_bytes()
    for length in range(1, len(content), len(content) // 20):
        path.write_bytes(content[:length])
        rejects(path, "expected a checkpoint of aerodrake")


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_no_flipped_bit_changes_the_network(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "flipped.pt"
    network = trained()
    save(path, network, PROVENANCE)
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(content)
    try:
        read, _ = load(path, JOINTS)
    except BadInput:
        return
    for name, tensor in network.state_dict().items():
        assert torch.equal(read.state_dict()[name], tensor), name


def test_too_large(tmp_path):
    path = tmp_path / "network.pt"
    path.write_bytes(bytes(MAX_BYTES + 1))
    rejects(path, f"at most {MAX_BYTES} bytes")


def test_compressed_bomb(tmp_path):
    path, content = tmp_path / "network.pt", io.BytesIO()
    torch.save({"format": FORMAT, "tensors": torch.zeros(10 * MAX_BYTES)}, content)
    with zipfile.ZipFile(content) as big, zipfile.ZipFile(path, "w", 8) as small:
        for entry in big.infolist():
            small.writestr(entry.filename, big.read(entry))
    assert path.stat().st_size < MAX_BYTES
    rejects(path, "expected a checkpoint of aerodrake")


class Trap:
    """Object whose unpickling calls a function."""

    def __reduce__(self):
        return pytest.fail, ("code in a checkpoint was run",)


@pytest.mark.parametrize("data", [[1, 2], {}, {"format": FORMAT}, Trap(), torch.zeros(3)])
def test_another_content(tmp_path, data):
    path = tmp_path / "network.pt"
    torch.save(data, path)
    rejects(path, "expected a checkpoint of aerodrake")


@pytest.mark.parametrize("key", ["format", "features", "hidden", "metadata", "tensors"])
@pytest.mark.parametrize("value", [None, 1.5, "text", [torch.zeros(2)], {"a": 1}])
def test_wrong_types(checkpoint, key, value):
    rejects(checkpoint(lambda data: data.update({key: value})), "network.pt: expected")


def test_unknown_format(checkpoint):
    path = checkpoint(lambda data: data.update(format=FORMAT + 1))
    rejects(path, f"expected a checkpoint of format {FORMAT}")


def test_wrong_joint_count(checkpoint):
    path = checkpoint(lambda data: None)
    rejects(path, "expected the 33 features of an arm of 7 joints, got 30", joints=7)


def test_wrong_feature_names(checkpoint):
    path = checkpoint(lambda data: data["features"].__setitem__(2, "heading_deg\n"))
    rejects(path, "expected the feature yaw_rad, got 'heading_deg")


def test_wrong_hidden_sizes(checkpoint):
    rejects(checkpoint(lambda data: data.update(hidden=[32, 64])), r"hidden layers of \[32, 32\]")


def test_wrong_metadata(checkpoint):
    path = checkpoint(lambda data: data["metadata"].pop("plant_hash"))
    rejects(path, "expected a checkpoint of aerodrake")


def test_missing_tensor(checkpoint):
    rejects(checkpoint(lambda data: data["tensors"].pop("scale")), "expected the tensors mean, sc")


@pytest.mark.parametrize(
    "tensor",
    [
        torch.zeros(32, 31, dtype=torch.float64),
        torch.zeros(1, dtype=torch.float64).expand(10**6, 10**6),
        torch.zeros(32, 32, dtype=torch.float32),
        torch.zeros(32, 32, dtype=torch.float64).to_sparse(),
        torch.zeros(32, 32, dtype=torch.float64, device="meta"),
        [0.0] * 32,
    ],
    ids=["shape", "huge view", "float32", "sparse", "meta", "list"],
)
def test_wrong_tensor(checkpoint, tensor):
    path = checkpoint(lambda data: data["tensors"].update({"hidden.2.weight": tensor}))
    rejects(path, r"expected hidden.2.weight to be \[32, 32\] of torch.float64")


@pytest.mark.parametrize("name", list(trained().state_dict()))
@pytest.mark.parametrize("number", [float("nan"), float("-inf")])
def test_nan_or_infinite_entries(checkpoint, name, number):
    path = checkpoint(lambda data: data["tensors"][name].view(-1)[-1].fill_(number))
    rejects(path, f"expected {name} to be finite")


@pytest.mark.parametrize("number", [0.0, -1.0])
def test_scale_that_is_not_positive(checkpoint, number):
    path = checkpoint(lambda data: data["tensors"]["scale"][3].fill_(number))
    rejects(path, "expected scale to be positive")

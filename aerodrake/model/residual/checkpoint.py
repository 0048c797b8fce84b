"""Checkpoint files of a residual network, with its provenance."""

import io
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import torch

from aerodrake.model.residual.features import HIDDEN, feature_names
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.support.errors import BadInput
from aerodrake.support.files import check_stored_zip, read_bounded, write_atomically

FORMAT = 2
"""Version of the file format."""

IMPLIED: dict[int, dict[str, str]] = {1: {"delta_unit": "m/s"}, FORMAT: {}}
"""Metadata that files lack, by their version."""

MAX_BYTES = 1_000_000
"""Largest accepted file, as a guard against hostile files."""


@dataclass(frozen=True)
class Provenance:
    """Origin of a network, which limits its validity.

    Attributes:
        version: Version of aerodrake.
        flight_interface: `trajectory` or `position`; a network is valid for one of them.
        delta_unit: Unit of its output, that of the equivalent model's residual.
        plant_hash: Hash of its vehicle, controllers and model (`fingerprint`).
        scenario_hash: Hash of the scenario of its training data.
    """

    version: str
    flight_interface: str
    delta_unit: str
    plant_hash: str
    scenario_hash: str


def save(path: Path, network: ResidualNetwork, provenance: Provenance) -> None:
    """Writes a checkpoint atomically; the same arguments give the same bytes.

    Raises:
        BadInput: if the file cannot be written.
    """
    content = io.BytesIO()
    data = {
        "format": FORMAT,
        "features": feature_names(network.joints),
        "hidden": list(HIDDEN),
        "metadata": asdict(provenance),
        "tensors": dict(network.state_dict()),  # With the scaler.
    }
    torch.save(data, content)
    write_atomically(path, content.getvalue())


def load(path: Path, joints: int) -> tuple[ResidualNetwork, Provenance]:
    """Reads a checkpoint that `save` wrote, for an arm of n = `joints`; runs no code in it.

    Raises:
        BadInput: if the file is missing, too large, not a checkpoint or of another format, for
            other features, or if its tensors have a wrong shape or type or NaN or infinite
            entries.
    """
    bad = partial(BadInput, path, "")
    data = _read(path)
    if data["format"] not in IMPLIED:
        raise bad(f"expected a checkpoint of format {FORMAT}, got another format")
    names, features = feature_names(joints), data["features"]
    if len(features) != len(names):
        expected = f"the {len(names)} features of an arm of {joints} joints"
        raise bad(f"expected {expected}, got {len(features)}")
    for name, other in zip(names, features, strict=True):
        if other != name:
            raise bad(f"expected the feature {name}, got {other!r:.40}")
    if data["hidden"] != list(HIDDEN):
        raise bad(f"expected hidden layers of {list(HIDDEN)} units")

    network = ResidualNetwork.untrained(joints, seed=0)
    _check_tensors(path, network.state_dict(), data["tensors"])
    network.load_state_dict(data["tensors"])
    return network, Provenance(**IMPLIED[data["format"]], **data["metadata"])


def _read(path: Path) -> dict[str, Any]:
    """Reads the checkpoint's mapping and checks its keys and plain types."""
    expected = "expected a checkpoint of aerodrake, the network.pt of a training"
    not_a_checkpoint = BadInput(path, "", f"{expected}, got another content")
    content, names = read_bounded(path, MAX_BYTES), {f.name for f in fields(Provenance)}
    try:
        check_stored_zip(content)  # As torch writes it; torch does not compare checksums.
    except ValueError as error:
        raise BadInput(path, "", f"{expected}, got {error}") from None
    try:
        data = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except Exception:  # torch.load does not document its errors on malformed files.
        raise not_a_checkpoint from None
    if (
        not isinstance(data, dict)
        or not isinstance(data.get("format"), int)
        or not _is_list_of(str, data.get("features"))
        or not _is_list_of(int, data.get("hidden"))
        or not isinstance(data.get("tensors"), dict)
        or not isinstance(data.get("metadata"), dict)
        or data["metadata"].keys() != names - IMPLIED.get(data["format"], {}).keys()
        or not _is_list_of(str, list(data["metadata"].values()))
    ):
        raise not_a_checkpoint
    return data


def _is_list_of(kind: type, value: object) -> bool:
    return isinstance(value, list) and all(isinstance(v, kind) for v in value)


def _check_tensors(path: Path, expected: dict[str, torch.Tensor], tensors: dict[str, Any]) -> None:
    if tensors.keys() != expected.keys():
        raise BadInput(path, "", f"expected the tensors {', '.join(expected)}")
    for name, like in expected.items():
        tensor = tensors[name]
        if (
            not isinstance(tensor, torch.Tensor)
            or tensor.shape != like.shape
            or tensor.dtype != like.dtype
            or tensor.layout != torch.strided
            or tensor.device != like.device
        ):
            raise BadInput(path, "", f"expected {name} to be {list(like.shape)} of {like.dtype}")
        if not tensor.isfinite().all():
            raise BadInput(path, "", f"expected {name} to be finite")
    if not (tensors["scale"] > 0).all():
        raise BadInput(path, "", "expected scale to be positive")

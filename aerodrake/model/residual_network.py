"""The network that estimates the residual velocity Delta of the base, and its checkpoint.

Two hidden layers of 32 units with ELU, as in the paper (section "Residual
Learning"). Everything is float64: the online update of the last layer is numpy
in float64, where steps of 1e-9 still count, and torch and numpy then agree to
rounding. At this size float32 would be no faster.
"""

from __future__ import annotations

import contextlib
import io
import os
import zipfile
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch

from aerodrake.errors import BadInput
from aerodrake.model.vehicle_state import VehicleState

HIDDEN = (32, 32)
"""Units of the hidden layers."""

PHI_SIZE = HIDDEN[-1] + 1
"""Length of phi: the last hidden activations and the 1 that the bias multiplies."""

FORMAT = 1
"""Version of the checkpoint's layout."""

MAX_BYTES = 1_000_000
"""No checkpoint is larger: a guard against hostile files."""


def feature_names(joints: int) -> list[str]:
    """Names of the 12 + 3 n features with their units, in the order of `features`."""
    arm = range(1, joints + 1)
    return [
        *("roll_rad", "pitch_rad", "yaw_rad"),
        *("v_x_m_s", "v_y_m_s", "v_z_m_s"),
        *("omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s"),
        *(f"q_{i}_rad" for i in arm),
        *(f"qdot_{i}_rad_s" for i in arm),
        *("a_x_m_s2", "a_y_m_s2", "a_z_m_s2"),
        *(f"qddot_{i}_rad_s2" for i in arm),
    ]


def features(state: VehicleState, u: np.ndarray) -> np.ndarray:
    """What the network sees: [Theta_B, v_B, omega_B, q, q', u_{k-1}].

    The paper lists "control inputs". u_k is not known when Delta is inferred,
    hence u_{k-1}, in training too.

    Args:
        state: Measured at t_k.
        u: (3 + n,) [p_B,d'', q_d''] in m/s^2 and rad/s^2, applied up to t_k.

    Returns:
        (12 + 3 n,) unscaled; v_B in the world frame, omega_B in the base frame.
    """
    omega_B = state.R_B.T @ state.omega_W
    return np.concatenate([state.rpy, state.v_B, omega_B, state.q, state.qdot, u])


@dataclass(frozen=True, eq=False)
class FeatureScaler:
    """(features - mean) / scale, frozen with the network it was trained for.

    Attributes:
        mean: (12 + 3 n,) in the features' units.
        scale: (12 + 3 n,) in the features' units, positive.
    """

    mean: np.ndarray
    scale: np.ndarray

    def __post_init__(self) -> None:
        for f in fields(self):
            frozen = np.array(getattr(self, f.name), dtype=np.float64)
            frozen.setflags(write=False)
            object.__setattr__(self, f.name, frozen)

    @classmethod
    def nominal(cls, joints: int) -> FeatureScaler:
        """Spread expected in gentle flight: for a network that has seen no data."""
        scale = np.concatenate(
            [
                np.full(3, 0.1),  # rad, Theta_B
                np.full(3, 0.3),  # m/s, v_B
                np.full(3, 0.3),  # rad/s, omega_B
                np.full(joints, 1.0),  # rad, q
                np.full(joints, 0.5),  # rad/s, q'
                np.full(3, 1.0),  # m/s^2, p_B,d''
                np.full(joints, 3.0),  # rad/s^2, q_d''
            ]
        )
        return cls(np.zeros_like(scale), scale)


class ResidualNetwork(torch.nn.Module):
    """Delta = theta [ELU(W_2 ELU(W_1 s + b_1) + b_2); 1], with s the scaled features.

    The last layer starts at zero, so that Delta is exactly zero until something
    is learned; the hidden layers start uniform in +-1/sqrt(inputs).

    Args:
        joints: n.
        scaler: For the 12 + 3 n features; fixed from here on.
        seed: Of the hidden layers; torch's global generator is left alone.
    """

    def __init__(self, joints: int, scaler: FeatureScaler, seed: int):
        super().__init__()
        self.joints = joints
        self.register_buffer("mean", torch.tensor(scaler.mean))
        self.register_buffer("scale", torch.tensor(scaler.scale))
        generator = torch.Generator().manual_seed(seed)
        inputs = len(feature_names(joints))
        first, second = HIDDEN
        self.hidden = torch.nn.Sequential(
            _linear(inputs, first, generator),
            torch.nn.ELU(),
            _linear(first, second, generator),
            torch.nn.ELU(),
        )
        self.last = _linear(second, 3, generator)
        torch.nn.init.zeros_(self.last.weight)
        torch.nn.init.zeros_(self.last.bias)

    @classmethod
    def untrained(cls, joints: int, seed: int) -> ResidualNetwork:
        """A network with the nominal scaler; its Delta is zero until its last layer learns."""
        return cls(joints, FeatureScaler.nominal(joints), seed)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """Delta (..., 3) in m/s from unscaled features (..., 12 + 3 n)."""
        return self.last(self.hidden((features - self.mean) / self.scale))

    def phi(self, features: np.ndarray) -> np.ndarray:
        """(..., 33) last hidden activations and a 1, from unscaled features (..., 12 + 3 n).

        Delta is `phi @ last_layer().T`.
        """
        with torch.inference_mode():
            scaled = (torch.from_numpy(features) - self.mean) / self.scale
            activations = self.hidden(scaled).numpy()
        phi = np.ones((*activations.shape[:-1], PHI_SIZE))
        phi[..., :-1] = activations
        return phi

    def last_layer(self) -> np.ndarray:
        """(3, 33) copy of theta, [weights, bias]: the paper's theta^l."""
        with torch.no_grad():
            return torch.column_stack([self.last.weight, self.last.bias]).numpy()


@dataclass(frozen=True)
class Provenance:
    """Where a network comes from, and so where it is valid.

    Attributes:
        version: Of aerodrake.
        flight_interface: `trajectory` or `position`; a network serves one of them.
        plant_hash: Of the vehicle it was trained on.
        scenario_hash: Of the scenario its data came from.
    """

    version: str
    flight_interface: str
    plant_hash: str
    scenario_hash: str


def save(path: Path, network: ResidualNetwork, metadata: Provenance) -> None:
    """Writes a checkpoint: all of it, or nothing.

    The same network and metadata give the same bytes.

    Raises:
        BadInput: if the file cannot be written.
    """
    path = Path(path)
    content = io.BytesIO()
    torch.save(
        {
            "format": FORMAT,
            "features": feature_names(network.joints),
            "hidden": list(HIDDEN),
            "metadata": asdict(metadata),
            "tensors": dict(network.state_dict()),  # The scaler is among them.
        },
        content,
    )
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_bytes(content.getvalue())
        os.replace(temporary, path)
    except OSError as error:
        raise BadInput(path, "", f"expected a writable file: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def load(path: Path, joints: int) -> tuple[ResidualNetwork, Provenance]:
    """Reads a checkpoint that `save` wrote, without running any code in it.

    Args:
        path: The file.
        joints: n of the vehicle that is to fly with it.

    Raises:
        BadInput: if the file is missing, too large, not a checkpoint or of
            another format, for other features, or holds tensors of the wrong
            shape or type or numbers that are not finite.
    """
    path = Path(path)
    data = _read(path)
    if data["format"] != FORMAT:
        raise BadInput(path, "", f"expected a checkpoint of format {FORMAT}, got another format")
    expected, found = feature_names(joints), data["features"]
    if len(found) != len(expected):
        raise BadInput(
            path,
            "",
            f"expected the {len(expected)} features of an arm of {joints} joints, "
            f"got {len(found)}",
        )
    for ours, theirs in zip(expected, found, strict=True):
        if ours != theirs:
            raise BadInput(path, "", f"expected the feature {ours}, got {theirs!r:.40}")
    if data["hidden"] != list(HIDDEN):
        raise BadInput(path, "", f"expected hidden layers of {list(HIDDEN)} units")

    network = ResidualNetwork.untrained(joints, seed=0)
    _check_tensors(path, network.state_dict(), data["tensors"])
    network.load_state_dict(data["tensors"])
    return network, Provenance(**data["metadata"])


def _linear(inputs: int, outputs: int, generator: torch.Generator) -> torch.nn.Linear:
    # skip_init, since torch's own initialisation draws from the global generator.
    layer = torch.nn.utils.skip_init(torch.nn.Linear, inputs, outputs, dtype=torch.float64)
    bound = inputs**-0.5
    torch.nn.init.uniform_(layer.weight, -bound, bound, generator=generator)
    torch.nn.init.uniform_(layer.bias, -bound, bound, generator=generator)
    return layer


def _read(path: Path) -> dict[str, Any]:
    """The checkpoint's mapping, its keys and plain types checked."""
    not_a_checkpoint = BadInput(path, "", "expected a checkpoint of aerodrake")
    try:
        with open(path, "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise BadInput(path, "", f"expected a readable file: {error.strerror}") from None
    if len(content) > MAX_BYTES:
        raise BadInput(path, "", f"expected a checkpoint of at most {MAX_BYTES} bytes")
    try:
        # torch stores and never compresses: what is small here stays small.
        entries = zipfile.ZipFile(io.BytesIO(content)).infolist()
        if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries):
            raise ValueError("compressed")
        data = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except Exception:  # What torch.load raises on a malformed file is not documented.
        raise not_a_checkpoint from None
    if (
        not isinstance(data, dict)
        or not isinstance(data.get("format"), int)
        or not _is_list_of(str, data.get("features"))
        or not _is_list_of(int, data.get("hidden"))
        or not isinstance(data.get("tensors"), dict)
        or not isinstance(data.get("metadata"), dict)
        or data["metadata"].keys() != {f.name for f in fields(Provenance)}
        or not _is_list_of(str, list(data["metadata"].values()))
    ):
        raise not_a_checkpoint
    return data


def _is_list_of(kind: type, value: object) -> bool:
    return isinstance(value, list) and all(isinstance(v, kind) for v in value)


def _check_tensors(
    path: Path, expected: dict[str, torch.Tensor], tensors: dict[str, Any]
) -> None:
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

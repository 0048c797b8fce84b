"""Files of samples of the residual, one `.npz` for each collection run."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.model.residual.samples import Samples
from aerodrake.support.errors import BadInput
from aerodrake.support.files import check_stored_zip, read_bounded, write_atomically

MAX_BYTES = 100_000_000
"""Largest accepted file, as a guard against hostile files."""

ARRAYS = ("features", "targets")
"""Names of the arrays of a dataset, besides `metadata`."""


def save_samples(path: Path, samples: Samples, metadata: dict[str, Any]) -> None:
    """Writes a dataset atomically, with its metadata as JSON in the array `metadata`.

    Raises:
        BadInput: if the file cannot be written.
    """
    content = io.BytesIO()
    arrays = dict(zip(ARRAYS, samples, strict=True))
    np.savez(content, **arrays, metadata=np.array(json.dumps(metadata)))
    write_atomically(path, content.getvalue())


def load_samples(path: Path, metadata: dict[str, Any], size: tuple[int, int]) -> Samples:
    """Reads a dataset that `save_samples` wrote, without running any code in it.

    Args:
        path: The file.
        metadata: Expected metadata.
        size: Expected size of the features, (T, 12 + 3 n).

    Raises:
        BadInput: if the file is missing, too large, not a dataset or not the expected one, or if
            its arrays have a wrong shape or type or NaN or infinite entries.
    """
    arrays = _read(path)
    if arrays["metadata"] != metadata:
        message = "expected the dataset of this collection run and scenario, got another"
        raise BadInput(path, "", message)
    for name, shape in zip(ARRAYS, (size, (size[0], 3)), strict=True):
        array = arrays[name]
        if array.shape != shape or array.dtype != np.float64:
            expected = f"expected {name} to be {list(shape)} of float64"
            raise BadInput(path, "", f"{expected}, got {list(array.shape)} of {array.dtype}")
        if not np.isfinite(array).all():
            raise BadInput(path, "", f"expected {name} to be finite")
    return arrays["features"], arrays["targets"]


def _read(path: Path) -> dict[str, Any]:
    """Reads the arrays, and the metadata from JSON."""
    content = read_bounded(path, MAX_BYTES)
    expected = "expected a dataset of aerodrake"
    try:
        check_stored_zip(content)  # As numpy writes it.
    except ValueError as error:
        raise BadInput(path, "", f"{expected}, got {error}") from None
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            if set(file.files) != {*ARRAYS, "metadata"}:
                raise ValueError("other arrays")
            arrays = {name: file[name] for name in file.files}
        return {**arrays, "metadata": json.loads(arrays["metadata"].item())}
    except Exception:  # numpy does not document its errors on malformed files.
        names = ", ".join((*ARRAYS, "metadata"))
        raise BadInput(path, "", f"{expected} with the arrays {names}, got others") from None

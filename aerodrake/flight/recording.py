"""Signals of a flight in a temporary file, since they may not fit into memory."""

import tempfile
import weakref
from collections.abc import Iterator, Mapping

import numpy as np

from aerodrake.support.errors import BadInput


class Recording(Mapping[str, np.ndarray]):
    """Signals by key, with their samples in a temporary file.

    Each access reads a new array (T,) or (T, width) from the file. The file is deleted with the
    recording.

    Args:
        columns: Column of each key in a sample for a plain series, or its range of columns.

    Raises:
        BadInput: if no folder of temporary files can be written.
    """

    def __init__(self, columns: Mapping[str, int | slice]):
        self._columns = columns
        self._times: list[np.ndarray] = []
        self._others: dict[str, np.ndarray] = {}
        self._blocks: list[tuple[int, int]] = []  # Offset and number of samples of each.
        self._newest: np.ndarray | None = None
        try:
            self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115
        except OSError as error:
            raise BadInput("TMPDIR", "", f"expected a writable folder: {error.strerror}") from None
        weakref.finalize(self, self._file.close)

    def append(self, times: np.ndarray, samples: np.ndarray) -> None:
        """Adds samples (size, T), one in each column, taken at times (T,) in s.

        Raises:
            BadInput: if the disk is full.
        """
        # After the last complete block, over an incomplete one that an interrupt left.
        before = sum(length for _, length in self._blocks)
        offset = self._file.seek(before * len(samples) * samples.itemsize)
        # Row by row, so that the samples of one key are adjacent in the file.
        rest = memoryview(samples.tobytes())
        try:
            while rest:  # A write to an almost full disk can be incomplete.
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            problem = f"cannot be written during the flight: {error.strerror}"
            raise BadInput(tempfile.gettempdir(), "", problem) from None
        self._times.append(times.copy())
        self._blocks.append((offset, samples.shape[1]))

    def fill(self, samples: np.ndarray) -> None:
        """Replaces NaN and infinity in samples (size, T) by the last finite value, or zero."""
        first = np.zeros(len(samples)) if self._newest is None else self._newest
        if not np.isfinite(samples).all():
            before = np.column_stack([first, samples])
            latest = np.where(np.isfinite(before), np.arange(before.shape[1]), 0)
            latest = np.maximum.accumulate(latest, axis=1)
            samples[:] = np.take_along_axis(before, latest, axis=1)[:, 1:]
        self._newest = samples[:, -1].copy()

    @property
    def times(self) -> np.ndarray:
        """(T,) s, times of the samples."""
        return np.concatenate(self._times)

    @property
    def end(self) -> float:
        """Time of the last sample in s; minus infinity without samples."""
        return self._times[-1][-1] if self._times else -np.inf

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        """Adds signals (T, ...) by key, which stay in memory."""
        self._others.update(signals)

    def __getitem__(self, key: str) -> np.ndarray:
        if key in self._others:
            return self._others[key]
        columns = self._columns[key]
        part = slice(columns, columns + 1) if isinstance(columns, int) else columns
        width = part.stop - part.start
        rows = np.empty((sum(length for _, length in self._blocks), width))
        start = 0
        for offset, length in self._blocks:
            block = np.empty((width, length))
            self._file.seek(offset + part.start * length * block.itemsize)
            self._file.readinto(block.data)
            rows[start : start + length] = block.T
            start += length
        return rows[:, 0] if isinstance(columns, int) else rows

    def __iter__(self) -> Iterator[str]:
        yield from self._columns
        yield from self._others

    def __len__(self) -> int:
        return len(self._columns) + len(self._others)

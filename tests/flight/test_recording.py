"""Signals in a file are read as they were written."""

import gc
import warnings

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from aerodrake.flight.recording import Recording
from aerodrake.support.errors import BadInput

COLUMNS = {"mode": 0, "p_B_m": slice(1, 4), "v_B_m_s": slice(4, 7)}


@given(lengths=st.lists(st.integers(0, 5), min_size=1, max_size=5), seed=st.integers(0, 9))
def test_signals_are_the_columns_of_all_samples(lengths, seed):
    samples = np.random.default_rng(seed).normal(size=(7, sum(lengths)))
    recording, times = Recording(COLUMNS), np.arange(sum(lengths)) / 100
    for start, length in zip(np.cumsum([0, *lengths]), lengths, strict=False):
        part = slice(start, start + length)
        # Column-major, as Drake's logs.
        recording.append(times[part], np.asfortranarray(samples)[:, part])
    np.testing.assert_array_equal(recording.times, times)
    for key, columns in COLUMNS.items():
        np.testing.assert_array_equal(recording[key], samples[columns].T)


def test_later_samples_do_not_change_earlier_signals():
    times, samples = np.zeros(1), np.ones((7, 1))
    recording = Recording(COLUMNS)
    recording.append(times, samples)
    times += 1
    samples += 1
    assert recording.times == [0] and recording["mode"] == [1]


def test_signals_in_memory_are_added():
    recording = Recording(COLUMNS)
    recording.append(np.zeros(2), np.zeros((7, 2)))
    tick_ms = np.array([1.0, 2.0, 3.0])
    recording.add({"tick_ms": tick_ms})
    assert list(recording) == [*COLUMNS, "tick_ms"] and len(recording) == 4
    assert recording["tick_ms"] is tick_ms
    with pytest.raises(KeyError):
        recording["p_E_m"]


def test_incomplete_writes_are_continued_and_a_full_disk_is_an_error(monkeypatch):
    recording = Recording(COLUMNS)
    samples = np.arange(70.0).reshape(7, 10)
    file = recording._file

    class ShortWrites:
        def write(self, content):
            return file.write(content[:33])

        def __getattr__(self, name):
            return getattr(file, name)

    recording._file = ShortWrites()
    recording.append(np.arange(10.0), samples)
    np.testing.assert_array_equal(recording["p_B_m"], samples[1:4].T)

    def full(content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(ShortWrites, "write", staticmethod(full), raising=True)
    with pytest.raises(BadInput, match="during the flight: No space left on device"):
        recording.append(np.arange(10.0), samples)


def test_its_file_is_closed_with_it():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        file = Recording(COLUMNS)._file
        gc.collect()
    assert file.closed and not caught


def test_without_a_writable_temporary_folder(monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", "/proc/none")
    with pytest.raises(BadInput, match="^TMPDIR: expected a writable folder: No such file"):
        Recording(COLUMNS)

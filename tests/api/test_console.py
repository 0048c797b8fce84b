"""Notes and bars on streams that are broken, and notes that are printed once."""

import io
import sys

import pytest

from aerodrake.api.console import Console
from aerodrake.support.compiled import CACHE


def full() -> io.TextIOWrapper:
    return open("/dev/full", "w", buffering=1)


@pytest.mark.parametrize("make", [full, lambda: None])
def test_broken_streams_do_not_end_a_flight(make, monkeypatch):
    """A script, other than a command, keeps its streams, with their errors for its own output."""
    monkeypatch.setattr(sys, "stdout", make())
    monkeypatch.setattr(sys, "stderr", make())
    console = Console(quiet=False)
    console.note(["one", "two"])
    with console.flight_bar("flight", 2.0) as bar:
        bar.update(1.0)
        bar.set_postfix_str("descending")
    assert bar.n == 1.0


def test_the_folder_of_compiled_code_is_noted_once(monkeypatch):
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    monkeypatch.setattr(CACHE, "_new", ["compiled code is kept in /tmp/x"])
    for _ in range(2):
        Console(quiet=False).note(["other"])
    assert sys.stdout.getvalue().count("note: compiled code is kept in /tmp/x\n") == 1
    assert sys.stdout.getvalue().count("note: other\n") == 2

"""Notes and progress bars of the functions in this folder."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from tqdm import tqdm

from aerodrake.support.compiled import CACHE, is_cold
from aerodrake.support.streams import OutputStream

FLIGHT_BAR = (
    "{desc} {percentage:3.0f}%|{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}, {rate_fmt}]"
)
"""Format of a progress bar over simulated time."""

LIVE_BAR = "{desc} {n:.1f}/{total:.1f} s{postfix} |{bar}|"
"""Format of a progress bar with the flight's state; fits into 80 columns."""


class Console:
    """Prints notes on standard output, and shows progress bars on standard error.

    A stream that cannot be written does not end the flight whose notes and progress it shows.

    Args:
        quiet: True to print and show nothing.
    """

    def __init__(self, quiet: bool):
        self._quiet = quiet
        self._output, self._errors = OutputStream(sys.stdout), OutputStream(sys.stderr)

    def say(self, text: str) -> None:
        """Prints a text."""
        if not self._quiet:
            print(text, file=self._output)

    def note(self, notes: Iterable[str]) -> None:
        """Prints notes, and others if compiled code has an unusual folder or is missing."""
        for note in (*notes, *CACHE.new_notes()):
            self.say(f"note: {note}")
        if is_cold():
            self.say("note: compiling the equations first; this takes a minute, once per machine")

    def bar(self, name: str | None, total: float | None, unit: str, **others: Any) -> tqdm:
        """Returns a progress bar up to `total`, if that is known."""
        shown = {"desc": name, "total": total, "unit": unit, "file": self._errors, **others}
        return tqdm(disable=self._quiet, **shown)

    @contextmanager
    def steps(self, total: int, unit: str) -> Iterator[Callable[[str], None]]:
        """Shows a progress bar over steps; yields a function that begins a step of a name."""
        with self.bar(None, total, unit) as bar:

            def begin(step: str) -> None:
                bar.set_description(step)
                bar.update()

            yield begin

    def flight_bar(self, name: str, total_s: float, form: str = FLIGHT_BAR) -> tqdm:
        """Returns a progress bar over simulated time."""
        return self.bar(name, total_s, "s", bar_format=form)

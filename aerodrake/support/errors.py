"""The errors a person can cause, as opposed to bugs."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class BadInput(Exception):
    """Input that cannot be used: a scenario, an option, a robot or a file.

    The message is one line that names the source (a file or an option), the
    dotted key where there is one, and what was expected with unit and range.
    Commands print it and exit with code 2.

    Args:
        source: The file or option the input came from.
        key: The dotted key inside the source; empty where there is none.
        message: What was expected, and what was found.
    """

    def __init__(self, source: object, key: str, message: str):
        super().__init__(str(source), key, message)  # What it is pickled by.

    def __str__(self) -> str:
        return ": ".join(_printable(part) for part in self.args if part)

    @property
    def source(self) -> str:
        """The file or option the input came from."""
        return self.args[0]

    @property
    def key(self) -> str:
        """The dotted key inside the source; empty where there is none."""
        return self.args[1]


class ScenarioError(BadInput):
    """A scenario that cannot be used, or a file that it names."""


class ProcessDied(Exception):
    """A process of a command that was killed or had no room: no bad input, and no bug of ours."""


@contextmanager
def file_at(source: object, key: str) -> Iterator[None]:
    """What is wrong with the file that a scenario names at `key` is wrong with the scenario."""
    try:
        yield
    except ScenarioError:
        raise
    except BadInput as error:
        raise ScenarioError(source, key, ": ".join(filter(None, error.args))) from None


def nearest(name: object, valid: Iterable[str]) -> str:
    """Returns a clause that names the valid name closest to `name`, if one is close, and all."""
    options = sorted(valid)
    names = f"valid: {', '.join(options)}"
    close = difflib.get_close_matches(str(name)[:100], options, n=1, cutoff=0.5)
    return f"did you mean '{close[0]}'? ({names})" if close else names


def _printable(text: str, most: int = 500) -> str:
    """One line without control characters, cut in the middle if it is too long."""
    if len(text) > most:
        text = f"{text[: most // 2]} ... {text[-most // 2 :]}"
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())

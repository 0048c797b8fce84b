"""Errors that a user can cause, as opposed to bugs."""

import difflib
import reprlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

_REPR = reprlib.Repr()  # Limits the depth and length of values in messages.
_REPR.maxlevel = 2
_REPR.maxstring = 60


class BadInput(Exception):
    """Invalid input: an argument, a scenario, a robot or a file.

    The message is one line with the source, the dotted key if there is one, and the expected value
    with unit and range. Commands print it and exit with code 2.

    Args:
        source: The file, argument, function or option that the input came from.
        key: The dotted key in the source, or empty.
        message: The expected and the given value.
    """

    def __init__(self, source: object, key: str, message: str):
        super().__init__(str(source), key, message)  # All three, so that it can be pickled.

    def __str__(self) -> str:
        return ": ".join(_printable(part) for part in self.args if part)

    @property
    def source(self) -> str:
        """The file, argument, function or option that the input came from."""
        return self.args[0]

    @property
    def key(self) -> str:
        """The dotted key in the source, or empty."""
        return self.args[1]


class ScenarioError(BadInput):
    """Invalid scenario, or invalid file that it names."""


class ProcessDied(Exception):
    """A process of a command, or at the other end of its link, died or lacks memory or disk."""


@contextmanager
def file_at(source: object, key: str) -> Iterator[None]:
    """Converts errors in a file that a scenario names at `key` to errors of the scenario."""
    try:
        yield
    except ScenarioError:
        raise
    except BadInput as error:
        raise ScenarioError(source, key, ": ".join(filter(None, error.args))) from None


@contextmanager
def sourced(source: object) -> Iterator[None]:
    """Names `source` in errors of a scenario."""
    try:
        yield
    except ScenarioError as error:
        raise ScenarioError(source, *error.args[1:]) from None


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Raises BadInput that names `target` in place of errors of writing to it.

    A broken pipe is not an error of the target, but of a stream that a callback writes to.
    """
    if "\0" in str(target):
        raise BadInput(target, "", "expected a path without a NUL")
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise BadInput(target, "", f"cannot be written: {error.strerror or error}") from None


def show(value: object) -> str:
    """Returns a short representation of any value for a message."""
    return _REPR.repr(value)


def nearest(name: object, valid: Iterable[str]) -> str:
    """Returns a clause with the valid name closest to `name`, if one is close, and all others."""
    options = sorted(valid)
    names = f"valid: {', '.join(options) or 'none'}"
    close = difflib.get_close_matches(str(name)[:100], options, n=1, cutoff=0.5)
    return f"did you mean '{close[0]}'? ({names})" if close else names


def _printable(text: str, most: int = 500) -> str:
    """Returns one line without control characters, shortened in the middle if it is too long."""
    if len(text) > most:
        text = f"{text[: most // 2]} ... {text[-most // 2 :]}"
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())

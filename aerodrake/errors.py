"""The errors a person can cause, as opposed to bugs."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


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
        where = f"{source}: {key}" if key else f"{source}"
        super().__init__(" ".join(f"{where}: {message}".split()))


def nearest(name: object, valid: Iterable[str]) -> str:
    """Returns a clause that names the valid name closest to `name`, and the rest."""
    options = sorted(valid)
    close = difflib.get_close_matches(str(name), options, n=1, cutoff=0.5)
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"{hint}(valid: {', '.join(options)})"

"""Log of Drake: recorded, and without places in its source code."""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

LOG = logging.getLogger("drake")
"""The log of Drake, in C++ and Python."""
PLACES = (
    r"<literal-string>\S*( (error|warning): )?",
    r"Failure at \S+ in \w+\(\): ",
    r"\S*bazel-out\S*",
    r"\S+\.(cc|h|cxx)(:|, line )\d+:?",
    r"(?<![\w:/])/([^/\s]+/)+",
)
"""Patterns of places in the parsed text and in Drake's source code, and of folders."""


def plain(message: str) -> str:
    """Returns a message of Drake on one line, without places in source code and folders."""
    for place in PLACES:
        message = re.sub(place, "", message)
    return " ".join(message.split())


@cache
def warn_once(message: str) -> None:
    """Logs a warning, once for each text and process."""
    LOG.warning(message)


@contextmanager
def recorded_log() -> Iterator[list[str]]:
    """Yields a list that Drake's messages are appended to, instead of being logged."""
    messages: list[str] = []

    def record(entry: logging.LogRecord) -> bool:
        messages.append(entry.getMessage())
        return False

    LOG.addFilter(record)
    try:
        yield messages
    finally:
        LOG.removeFilter(record)

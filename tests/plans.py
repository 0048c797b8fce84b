"""Distributions of a sweep from the texts of the command line."""

from collections.abc import Iterable


def by_key(assignments: Iterable[str]) -> dict[str, str]:
    """Returns the distribution of each key in texts `KEY=DISTRIBUTION`."""
    return dict(text.split("=", 1) for text in assignments)

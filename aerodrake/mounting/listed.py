"""Names and numbers in the sentences about a conversion."""

from collections.abc import Iterable

MOST = 12
"""Largest count of names in a sentence."""


def listed(names: Iterable[str]) -> str:
    """Returns names in a row, and the count of those beyond the first `MOST`."""
    names = list(names)
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return ", ".join(names[:MOST]) + more


def shown(number: float) -> str:
    """Returns a number with four significant digits."""
    return f"{number:.4g}"

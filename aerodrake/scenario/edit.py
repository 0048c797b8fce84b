"""Edits of scenario files that keep every other byte: comments, order and layout."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import yaml

from aerodrake.support.errors import BadInput
from aerodrake.support.files import write_whole


def replace_numbers(path: Path, key: str, numbers: Sequence[float]) -> None:
    """Puts `numbers` in place of those that a scenario file has at `key`, at once or not at all.

    Args:
        path: A scenario file that has been read and found valid.
        key: The dotted key of a list of as many numbers.
        numbers: What it is to hold.

    Raises:
        BadInput: if the file does not have the key, or cannot be written.
    """
    text = _text(path)
    places = _places(path, text, key)
    for (start, end), number in reversed([*zip(places, numbers, strict=True)]):
        text = f"{text[:start]}{float(number)!r}{text[end:]}"
    write_whole(path, text.encode("utf-8"))


def check_replaceable(path: Path, key: str) -> None:
    """Tells beforehand whether `replace_numbers` will find what it needs.

    Raises:
        BadInput: if the file does not have the key, or cannot be written.
    """
    _places(path, _text(path), key)
    for place in (path, path.resolve().parent):
        if not os.access(place, os.W_OK):
            raise BadInput(place, "", "cannot be written: Permission denied")


def _text(path: Path) -> str:
    """The file, its line ends as they are."""
    try:
        return path.read_bytes().decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(path, "", f"cannot be read: {error}") from None


def _places(path: Path, text: str, key: str) -> list[tuple[int, int]]:
    """From where to where in the text each number of the list at `key` stands."""
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    for name in key.split("."):
        entries = node.value if isinstance(node, yaml.MappingNode) else []
        node = next((value for entry, value in entries if entry.value == name), None)
    if not isinstance(node, yaml.SequenceNode):
        raise BadInput(path, key, "expected the key in the file, with a list of numbers to replace")
    return [(item.start_mark.index, item.end_mark.index) for item in node.value]

"""Edits of scenario files that preserve every other byte: comments, order and layout."""

import os
from collections.abc import Sequence
from pathlib import Path

import yaml

from aerodrake.scenario.load import MAX_FILE_BYTES
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded, write_atomically


def replace_numbers(path: Path, key: str, numbers: Sequence[float]) -> None:
    """Replaces the list of numbers at `key` of a scenario file, in one atomic write.

    Args:
        path: A valid scenario file.
        key: The dotted key of a list of as many numbers.
        numbers: The new values.

    Raises:
        BadInput: if the file does not have the key, or cannot be written.
    """
    text, spans = _parse(path, key)
    for (start, end), number in reversed([*zip(spans, numbers, strict=True)]):
        text = f"{text[:start]}{float(number)!r}{text[end:]}"
    write_atomically(path, text.encode("utf-8"))


def check_replaceable(path: Path, key: str) -> None:
    """Checks in advance that `replace_numbers` can edit the file.

    Raises:
        BadInput: if the file does not have the key, or cannot be written.
    """
    _parse(path, key)
    for written in (path, path.resolve().parent):
        if not os.access(written, os.W_OK):
            raise BadInput(written, "", "cannot be written: Permission denied")


def _parse(path: Path, key: str) -> tuple[str, list[tuple[int, int]]]:
    """Returns the text, and in it the start and end of each number of the list at `key`."""
    text = read_bounded(path, MAX_FILE_BYTES).decode("utf-8")  # Preserves the line ends.
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    for name in key.split("."):
        entries = node.value if isinstance(node, yaml.MappingNode) else []
        node = next((value for entry, value in entries if entry.value == name), None)
    if not isinstance(node, yaml.SequenceNode):
        raise BadInput(path, key, "expected this key in the file, with a list of numbers")
    return text, [(item.start_mark.index, item.end_mark.index) for item in node.value]

"""What docstrings of systems say of their ports, state and rate."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass

SECTION = re.compile(r"^(Ports|State, rate|State|Rate|Attributes|Args|Raises|Returns|Keys):(.*)$")
PORT = re.compile(r"^(in|out) ((?:`\w+` \(.*?\)(?:, | and )?)+)(?:: |\. )(.*)$")


@dataclass(frozen=True)
class Docstring:
    """A docstring, taken apart.

    Attributes:
        text: Its paragraphs outside of sections.
        sections: Their text by title, without indentation.
    """

    text: str
    sections: dict[str, str]

    @classmethod
    def of(cls, thing: object) -> Docstring:
        """That of a class, function or module; empty if there is none."""
        text: list[str] = []
        sections: dict[str, list[str]] = {}
        lines = text
        for line in (inspect.getdoc(thing) or "").splitlines():
            if match := SECTION.match(line):
                lines = sections.setdefault(match[1], [])
                line = match[2].strip()
            elif lines is not text and line and not line.startswith(" "):
                lines = text  # A paragraph after the sections.
            lines.append(line)
        return cls(_joined(text), {title: _joined(own) for title, own in sections.items()})

    @property
    def ports(self) -> dict[tuple[str, str], str]:
        """What is said of each port, by (`in` or `out`, name)."""
        said: dict[tuple[str, str], str] = {}
        for entry in _entries(self.sections.get("Ports", "")):
            if match := PORT.match(entry):
                for name in re.findall(r"`(\w+)` \(", match[2]):
                    said[match[1], name] = match[3]
        return said


def _joined(lines: list[str]) -> str:
    return inspect.cleandoc("\n".join(["", *lines])).strip()


def _entries(text: str) -> list[str]:
    """Lines that begin with `in` or `out`, each with those that continue it."""
    entries: list[str] = []
    for line in text.splitlines():
        if re.match(r"(in|out) `", line):
            entries.append(line)
        elif entries and line.startswith(" "):
            entries[-1] += " " + line.strip()
    return entries

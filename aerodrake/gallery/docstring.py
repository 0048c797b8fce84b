"""Parser of docstrings of systems, with sections for ports, state and rate."""

import inspect
import re
from dataclasses import dataclass
from typing import Self

SECTION = re.compile(r"^(Ports|State, rate|State|Rate|Attributes|Args|Raises|Returns|Keys):(.*)$")
ENTRY = re.compile(r"^(?:in|out) `.*(?:\n +.*)*", re.MULTILINE)
"""A description of ports, with its continuation lines."""
PORT = re.compile(r"^(in|out) ((?:`\w+` \(.*?\)(?:, | and )?)+)(?:: |\. )(.*)$")


@dataclass(frozen=True)
class Docstring:
    """A parsed docstring.

    Attributes:
        text: Paragraphs outside of sections.
        sections: Text of the sections by title, without indentation.
    """

    text: str
    sections: dict[str, str]

    @classmethod
    def of(cls, thing: object) -> Self:
        """Parses the docstring of a class, function or module; empty if it has none."""
        return cls.parse(inspect.getdoc(thing) or "")

    @classmethod
    def parse(cls, docstring: str) -> Self:
        """Parses a docstring without indentation."""
        text: list[str] = []
        sections: dict[str, list[str]] = {}
        lines = text
        for line in docstring.splitlines():
            if match := SECTION.match(line):
                lines = sections.setdefault(match[1], [])
                line = match[2].strip()
            elif lines is not text and line and not line.startswith(" "):
                lines = text  # A paragraph after the sections.
            lines.append(line)
        return cls(_joined(text), {title: _joined(own) for title, own in sections.items()})

    @property
    def ports(self) -> dict[tuple[str, str], str]:
        """Descriptions of the ports by (`in` or `out`, name)."""
        descriptions: dict[tuple[str, str], str] = {}
        for entry in ENTRY.findall(self.sections.get("Ports", "")):
            if match := PORT.match(re.sub(r"\n *", " ", entry)):
                for name in re.findall(r"`(\w+)` \(", match[2]):
                    descriptions[match[1], name] = match[3]
        return descriptions


def _joined(lines: list[str]) -> str:
    return inspect.cleandoc("\n".join(["", *lines])).strip()

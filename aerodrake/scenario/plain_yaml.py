"""The YAML of scenarios: plain values, each written out.

The parser is of YAML 1.1, where 010 is 8, 1:30 is 90, off is false and 1e-3 is a
text. Here, as in YAML 1.2, numbers are decimal, true and false are the only
truth values, and whatever else is not quoted is text: a field that expects a
number refuses it and shows it as it was written.
"""

from __future__ import annotations

import json
import re
from typing import Any, NoReturn

import yaml

from aerodrake.support.errors import ScenarioError

MAX_DEPTH = 10
MAX_VALUES = 10_000
"""A scenario is never deeper, and never has more values: a guard against hostile files."""

TAGS = {
    "null": r"~|null|Null|NULL|",
    "bool": r"true|True|TRUE|false|False|FALSE",
    # Longer ones are whole numbers no more, and Python would not read them all.
    "int": r"[-+]?(0|[1-9][0-9]{0,17})",
    "float": r"[-+]?((0|[1-9][0-9]*)(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?"
    r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
}
"""How what is not quoted has to look like to be anything but text; the first that fits."""


def parse(text: str, source: object, key: str = "") -> Any:
    """Reads one value: mappings, lists, text, numbers, truth values and nothing.

    Aliases, tags, keys given twice or that are no text, and what is nested too deep are refused.

    Args:
        text: The YAML.
        source: Named in errors: the file or option that `text` came from.
        key: Where in the scenario the value belongs; empty for all of it.

    Raises:
        ScenarioError: with the key that it is about, as far as it is known.
    """
    try:
        loader = _Loader(text, source, key)
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise ScenarioError(source, key, f"expected YAML; line {line}: {error.reason}") from None
    try:
        return loader.get_single_data()
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise ScenarioError(source, loader.key, f"expected YAML; {line}{error.problem}") from None
    except (ValueError, OverflowError) as error:  # Of a character beyond all characters.
        line = f"line {loader.line + 1}"
        raise ScenarioError(source, loader.key, f"expected YAML; {line}: {error}") from None


def dump(data: Any) -> str:
    """The reverse of `parse`, in YAML that means the same by either version."""
    return yaml.dump(data, Dumper=_Dumper, default_flow_style=None, allow_unicode=True)


def dump_line(value: Any) -> str:
    """One plain value as `parse` reads it back, to the last bit; a word without quotes if it can.

    In a list even a comma would end a word that has none.
    """
    if isinstance(value, str) and re.fullmatch(r"[\w./:+-]+", value) and _reads_back(value):
        return value
    return json.dumps(value, ensure_ascii=False)  # YAML as well.


def _reads_back(word: str) -> bool:
    try:
        return parse(f"[{word}]", "") == [word]
    except ScenarioError:
        return False


class _Loader(yaml.SafeLoader):
    """Builds plain values, with an eye on where in the scenario it is."""

    yaml_implicit_resolvers: dict[str | None, list[Any]] = {}  # None of YAML 1.1.

    def __init__(self, text: str, source: object, key: str):
        super().__init__(text)
        self._source = source
        self._path = [f".{key}"] if key else []
        self._depth = self._values = 0

    @property
    def key(self) -> str:
        """Dotted, of the value that is being read."""
        return "".join(self._path).removeprefix(".")

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node:
        """As PyYAML's, of which `index` is the node of a key or the number of an item."""
        event = self.peek_event()
        names = parent is not None and index is None
        if index is not None:
            self._path.append(f"[{index}]" if isinstance(index, int) else f".{index.value}")
        self._depth += 1
        self._values += 1
        if getattr(event, "anchor", None) is not None:
            self._refuse(event, "expected no anchors and aliases; write the value out")
        if getattr(event, "tag", None) is not None:
            self._refuse(event, f"expected a value without a tag, got {event.tag}")
        if names and not isinstance(event, yaml.ScalarEvent):
            self._refuse(event, "expected a name as key")
        if self._depth > MAX_DEPTH:
            self._refuse(event, f"expected no more than {MAX_DEPTH} levels")
        if self._values > MAX_VALUES:
            self._refuse(event, f"expected no more than {MAX_VALUES} values")
        node = super().compose_node(parent, index)
        if names and node.tag != "tag:yaml.org,2002:str":
            self._refuse(event, f"expected a name as key, got {node.value}")
        if isinstance(node, yaml.MappingNode):
            self._check_names(node)
        self._depth -= 1
        if index is not None:
            self._path.pop()
        return node

    def _check_names(self, node: yaml.MappingNode) -> None:
        seen = set()
        for name, _ in node.value:
            if name.value in seen:
                self._path.append(f".{name.value}")
                self._refuse(name, "expected each key once")
            seen.add(name.value)

    def _refuse(self, place: yaml.Event | yaml.Node, message: str) -> NoReturn:
        line = f"line {place.start_mark.line + 1}"
        raise ScenarioError(self._source, self.key, f"{line}: {message}")


class _Dumper(yaml.SafeDumper):
    """Quotes what would not be text to `_Loader`, and what would not be to YAML 1.1."""


for _tag, _pattern in TAGS.items():
    for _kind in (_Loader, _Dumper):
        _kind.add_implicit_resolver(
            f"tag:yaml.org,2002:{_tag}", re.compile(f"(?:{_pattern})$"), None
        )

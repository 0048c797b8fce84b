"""Parser and writer of the YAML of scenarios: plain values without aliases and tags.

PyYAML implements YAML 1.1, where 010 is 8, 1:30 is 90, off is false and 1e-3 is a string.
Here, as in YAML 1.2, numbers are decimal, true and false are the only booleans, and any other
unquoted value is a string: a field that expects a number refuses it and shows it as written.
"""

import json
import re
from typing import Any, NoReturn

import yaml

from aerodrake.support.errors import ScenarioError

MAX_DEPTH = 10
MAX_VALUES = 10_000
"""Largest depth and number of values of a scenario; protects against hostile files."""

TAGS = {
    "null": r"~|null|Null|NULL|",
    "bool": r"true|True|TRUE|false|False|FALSE",
    # More digits are a float: Python limits the length of an int that it parses.
    "int": r"[-+]?(0|[1-9][0-9]{0,17})",
    "float": r"[-+]?((0|[1-9][0-9]*)(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?"
    r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
}
"""YAML tag -> pattern of the unquoted values that have it; the first match counts."""


def parse(text: str, source: object, key: str = "") -> Any:
    """Returns the value of a YAML document: mappings, lists, strings, numbers, booleans and None.

    Args:
        text: The YAML.
        source: Named in errors: the file or option that `text` came from.
        key: Dotted key of the value in the scenario; empty for the whole scenario.

    Raises:
        ScenarioError: on invalid YAML, aliases, tags, duplicate keys, keys that are not strings,
            and on too many levels or values; with the dotted key as far as it is known.
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
    except (ValueError, OverflowError) as error:  # An escape sequence above the last character.
        line = f"line {loader.line + 1}"
        raise ScenarioError(source, loader.key, f"expected YAML; {line}: {error}") from None


def dump(data: Any) -> str:
    """Returns YAML that `parse` reads back, and that has the same values in YAML 1.1 and 1.2."""
    return yaml.dump(data, Dumper=_Dumper, default_flow_style=None, allow_unicode=True)


def dump_line(value: Any) -> str:
    """Returns one line that `parse` reads back exactly, a word without quotes where possible."""
    if isinstance(value, str) and re.fullmatch(r"[\w./:+-]+", value) and _reads_back(value):
        return value
    return json.dumps(value, ensure_ascii=False)  # JSON is valid YAML.


def _reads_back(word: str) -> bool:
    """Returns True if a word without quotes is read back, even in a list."""
    try:
        return parse(f"[{word}]", "") == [word]
    except ScenarioError:
        return False


class _Loader(yaml.SafeLoader):
    """Builds plain values and keeps the dotted key of the current one for messages."""

    yaml_implicit_resolvers: dict[str | None, list[Any]] = {}  # Drops those of YAML 1.1.

    def __init__(self, text: str, source: object, key: str):
        super().__init__(text)
        self._source = source
        self._path = [f".{key}"] if key else []
        self._depth = self._values = 0

    @property
    def key(self) -> str:
        """Dotted key of the value that is being read."""
        return "".join(self._path).removeprefix(".")

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node:
        """Composes a node as PyYAML does; `index` is a value's key node or an item's number."""
        event = self.peek_event()
        is_key = parent is not None and index is None
        if index is not None:
            self._path.append(f"[{index}]" if isinstance(index, int) else f".{index.value}")
        self._depth += 1
        self._values += 1
        if getattr(event, "anchor", None) is not None:
            self._refuse(event, "expected a value without anchors and aliases")
        if getattr(event, "tag", None) is not None:
            self._refuse(event, f"expected a value without a tag, got {event.tag}")
        if is_key and not isinstance(event, yaml.ScalarEvent):
            self._refuse(event, "expected a name as key")
        if self._depth > MAX_DEPTH:
            self._refuse(event, f"expected no more than {MAX_DEPTH} levels")
        if self._values > MAX_VALUES:
            self._refuse(event, f"expected no more than {MAX_VALUES} values")
        node = super().compose_node(parent, index)
        if is_key and node.tag != "tag:yaml.org,2002:str":
            self._refuse(event, f"expected a name as key, got {node.value}")
        if isinstance(node, yaml.MappingNode):
            self._check_unique(node)
        self._depth -= 1
        if index is not None:
            self._path.pop()
        return node

    def _check_unique(self, node: yaml.MappingNode) -> None:
        seen = set()
        for name, _ in node.value:
            if name.value in seen:
                self._path.append(f".{name.value}")
                self._refuse(name, "expected each key once")
            seen.add(name.value)

    def _refuse(self, item: yaml.Event | yaml.Node, message: str) -> NoReturn:
        line = f"line {item.start_mark.line + 1}"
        raise ScenarioError(self._source, self.key, f"{line}: {message}")


class _Dumper(yaml.SafeDumper):
    """Quotes strings that `_Loader` or YAML 1.1 would read as another type."""


for _tag, _pattern in TAGS.items():
    for _kind in (_Loader, _Dumper):
        _kind.add_implicit_resolver(
            f"tag:yaml.org,2002:{_tag}", re.compile(f"(?:{_pattern})$"), None
        )

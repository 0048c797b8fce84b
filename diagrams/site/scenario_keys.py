"""Pages of the keys of a scenario and of the command line, from their declarations."""

import argparse
import ast
import dataclasses
import inspect
import math
import types
import typing
from collections.abc import Iterator
from pathlib import Path

from api_pages import write_if_changed
from sphinx.application import Sphinx

from aerodrake.cli import make_parser
from aerodrake.scenario import Scenario


def setup(app: Sphinx) -> dict[str, bool]:
    """Writes the pages before Sphinx looks for its sources."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(app: Sphinx) -> None:
    """Writes `api/scenario_keys.md` and `api/command_line.md`."""
    folder = Path(app.srcdir, "api")
    folder.mkdir(exist_ok=True)
    pages = {"scenario_keys.md": keys_page(), "command_line.md": command_page()}
    for name, text in pages.items():
        write_if_changed(folder / name, text)


def keys_page() -> str:
    """Returns a table for each section of a scenario."""
    text = "# Keys of a scenario\n\n"
    text += "Defaults are those of a scenario without the key. A list without a length has one "
    text += "number for each joint. A section with `kind` has the keys of that kind.\n"
    for key, section in sections(Scenario, ""):
        text += f"\n## {heading(key, section)}\n\n{summary(section)}\n\n"
        if rows := list(table(section, key)):
            text += "| key | default | unit | range | meaning |\n|---|---|---|---|---|\n"
            text += "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return text


def heading(key: str, section: type) -> str:
    kind = getattr(section, "kind", "")
    return f"`{key or 'top level'}`" + (f", kind `{kind}`" if kind else "")


def summary(section: type) -> str:
    return (inspect.getdoc(section) or "").split("\n\n")[0].replace("\n", " ")


def sections(cls: type, key: str) -> Iterator[tuple[str, type]]:
    """Yields the sections below a class with their dotted keys, the class first."""
    yield key, cls
    for name, hint in typing.get_type_hints(cls).items():
        element = next(iter(typing.get_args(hint)), None)
        listed = isinstance(element, types.UnionType)
        union = typing.get_args(element) if listed else typing.get_args(hint) or (hint,)
        for option in union:
            if dataclasses.is_dataclass(option):
                yield from sections(option, f"{key}.{name}".lstrip(".") + "[i]" * listed)


def table(section: type, key: str) -> Iterator[tuple[str, ...]]:
    """Yields key, default, unit, range and meaning of each field that is a value."""
    meanings = comments(section)
    for field in dataclasses.fields(section):
        if "provenance" in field.metadata:
            continue  # No key of a file.
        meta = field.metadata
        if not {"unit", "options", "file"} & {*meta} and not isinstance(field.default, bool | str):
            continue
        name = f"{key}.{field.name}".lstrip(".")
        span = "" if "low" not in meta else f"{limit(meta['low'])} to {limit(meta['high'])}"
        if "options" in meta:
            span = ", ".join(f"`{option}`" for option in meta["options"])
        unit = "" if meta.get("unit") == "1" else meta.get("unit", "")
        yield f"`{name}`", default(field), unit, span, meanings.get(field.name, "")


def limit(value: float) -> str:
    if not math.isfinite(value):
        return "any"
    return f"{value}" if isinstance(value, int) else f"{value:g}"


def default(field: dataclasses.Field) -> str:
    value = field.default
    if value is dataclasses.MISSING:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else f"{value}".replace("_", r"\_")


def comments(section: type) -> dict[str, str]:
    """Returns the comment above each field, by the field's name."""
    meanings: dict[str, str] = {}
    for cls in reversed(section.__mro__[:-1]):
        text = inspect.getsource(cls)
        source = text.splitlines()
        for node in ast.parse(text).body[0].body:
            if isinstance(node, ast.AnnAssign):
                at, above = node.lineno - 2, []
                while source[at].lstrip().startswith("#"):
                    above.insert(0, source[at].strip(" #"))
                    at -= 1
                meanings[node.target.id] = " ".join(above).replace("|", r"\|")
    return meanings


def command_page() -> str:
    """Returns the help of each command."""
    text = "# Command line\n\n```text\n" + make_parser().format_help() + "```\n"
    for action in make_parser()._subparsers._group_actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, parser in action.choices.items():
                text += f"\n## aerodrake {name}\n\n```text\n{parser.format_help()}```\n"
    return text

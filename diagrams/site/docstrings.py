"""Docstrings, which are plain text with code in backticks, as reStructuredText."""

import re
from collections.abc import Iterator
from functools import cache

from docutils import nodes
from sphinx.application import Sphinx

TITLED = re.compile(r"^(Ports|State, rate|State|Rate|Keys[^:]*):(.*)$")
"""Sections of systems that Napoleon does not know."""
KNOWN = re.compile(r"^(Args|Attributes|Returns|Raises|Yields):$")
CODE = re.compile(r"(``.*?``|`[^`]*`)")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connects the conversion, before Napoleon's, and the resolution of short names."""
    app.connect("autodoc-process-docstring", convert, priority=100)
    app.connect("autodoc-skip-member", skip_fields)
    app.connect("missing-reference", resolve_short_name)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def convert(app, what, name, thing, options, lines: list[str]) -> None:
    """Replaces the lines of a docstring."""
    lines[:] = restructured(lines)


def skip_fields(app, what, name, thing, skip, options) -> bool | None:
    """Leaves out the fields of named tuples, which `Attributes` describes."""
    return True if type(thing).__name__ == "_tuplegetter" else None


def restructured(lines: list[str]) -> Iterator[str]:
    """Yields reStructuredText: formulas and tables as literal blocks, ports as lists."""
    base, literal, section = 0, False, False
    previous = ""
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if line and literal and indent <= base:
            literal = False
        if line and not literal and not previous and indent >= base + 4 and not section:
            yield from (" " * base + "::", "")
            literal = True
        if literal or not line:
            yield line
        elif indent == 0 and (match := TITLED.match(line)):
            section = True
            yield from ("", f"**{match[1]}**", "")
            if match[2]:
                yield "- " + escaped(match[2].strip())
        elif section and indent == 4:
            yield "- " + escaped(line.strip())
        elif section and indent > 4:
            yield "  " + escaped(line.strip())
        else:
            if section:
                yield ""
            section = False
            base = indent
            yield line if KNOWN.match(line) else escaped(line)
        previous = line


def escaped(line: str) -> str:
    """Returns a line in which only code in backticks and the dashes of lists are markup."""
    parts = CODE.split(line)
    parts[::2] = [re.sub(r"([\\*|]|_(?!\w))", r"\\\1", text) for text in parts[::2]]
    parts[2::2] = [re.sub(r"^(?=\w)", r"\\ ", text) for text in parts[2::2]]
    return "".join(parts)


@cache
def names_by_ending(app: Sphinx) -> dict[str, list[str]]:
    """Returns the full names of all objects by their last part."""
    names: dict[str, list[str]] = {}
    for name in app.env.domains["py"].objects:
        names.setdefault(name.rpartition(".")[2], []).append(name)
    return names


def resolve_short_name(app, env, node, contnode) -> nodes.reference | None:
    """Links `Name` and `Class.name` to the one object of the package that ends so."""
    target = node.get("reftarget", "")
    if node.get("refdomain") != "py" or not re.fullmatch(r"[\w.]+", target):
        return None
    candidates = names_by_ending(app).get(target.rpartition(".")[2], ())
    matches = [name for name in candidates if name.endswith("." + target)]
    if len(matches) != 1:
        return None
    entry = env.domains["py"].objects[matches[0]]
    source = node.get("refdoc") or env.docname
    uri = app.builder.get_relative_uri(source, entry.docname)
    return nodes.reference("", "", contnode, internal=True, refuri=f"{uri}#{entry.node_id}")

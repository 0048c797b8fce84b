"""Files with the page and the graphs of each diagram and system."""

import difflib
import re
import shutil
import subprocess
from collections.abc import Collection, Iterable, Mapping
from os import PathLike
from pathlib import Path

from pydrake.systems.framework import System

from aerodrake.gallery.dot import to_dot
from aerodrake.gallery.graph import label, systems_by_name
from aerodrake.gallery.loops import every_loop
from aerodrake.gallery.mermaid import to_mermaid
from aerodrake.gallery.n2_chart import n2_svg
from aerodrake.gallery.ports import opens
from aerodrake.gallery.system_page import system_page
from aerodrake.support.arguments import check_whole
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.files import write_atomically
from aerodrake.support.limits import DEPTH
from aerodrake.support.run_folder import existing_folder

DOT_TIMEOUT_S = 60.0
"""Time limit of Graphviz, which needs less than a second for the closed loop."""

Shown = str | System
"""A system to draw: its name in `gallery`, or the system itself."""


def graph(
    systems: Shown | Iterable[Shown] | None = None,
    out: str | PathLike[str] = "graphs",
    depth: int = 2,
) -> list[Path]:
    """Writes a page and the graphs of diagrams and systems, and returns the paths.

    They are `NAME.md`, `NAME.dot`, `NAME.mmd` (Mermaid) and, of an opened diagram, `NAME_n2.svg`,
    an N-squared chart. With Graphviz also `NAME.svg` and `NAME.png`. Pages link to each other if
    one call writes them.

    Args:
        systems: A name such as `closed_loop`, `station`, `coordinator` or `mpc`, a Diagram or
            LeafSystem with a name, or several of them; None for all systems of the package.
        out: Folder, created if missing.
        depth: Number of levels of diagrams to open.

    Raises:
        BadInput: if a name is unknown, `systems` or `depth` are invalid, or `out` cannot be
            written.
    """
    check_whole("depth", depth, *DEPTH)
    chosen = _chosen(systems)
    folder = existing_folder(out)
    return [
        path
        for name, system in chosen.items()
        for path in export(name, system, folder, depth, chosen)
    ]


def export(
    name: str, system: System, folder: Path, depth: int, pages: Collection[str] = ()
) -> list[Path]:
    """Writes the files of one system into an existing folder, as `graph` does; returns the paths.

    The other arguments are those of `texts`.
    """
    contents = {file: text.encode() for file, text in texts(name, system, depth, pages).items()}
    dot = contents[f"{name}.dot"]
    contents |= {f"{name}.{form}": _drawn(dot, form) for form in ("svg", "png")}
    written = []
    for file, content in contents.items():
        if content:
            written.append(folder / file)
            write_atomically(written[-1], content)
    return written


def texts(name: str, system: System, depth: int, pages: Collection[str] = ()) -> dict[str, str]:
    """Returns the page, graphs and chart of a system by name of the file.

    Args:
        name: Stem of the names of the files.
        system: Diagram or leaf system.
        depth: Number of levels of diagrams to open.
        pages: Names with a page in the same folder, for links.
    """
    files = {
        f"{name}.md": system_page(name, system, depth, pages),
        f"{name}.dot": to_dot(system, depth),
        f"{name}.mmd": to_mermaid(system, depth),
    }
    chart = {f"{name}_n2.svg": n2_svg(system, depth)} if opens(system, depth) else {}
    return files | chart


def gallery(names: Collection[str] = ()) -> dict[str, System]:
    """Returns all diagrams and systems by name, from the default scenario if it has them.

    Other loops of `every_loop` have the others. They are built if one of `names` is missing, or if
    `names` is empty. A system of the package that replaces another one of the same name has the
    name of its class, such as `faulty_mpc`.
    """
    systems: dict[str, System] = {}
    for loop in every_loop():
        for name, inner in systems_by_name(loop).items():
            known = systems.get(name)
            is_drakes = type(inner).__module__.startswith("pydrake")
            if known is not None and type(known) is not type(inner) and not is_drakes:
                name = "_".join(_camel_words(type(inner).__name__)).lower()
            systems.setdefault(name, inner)
        if names and systems.keys() >= set(names):
            break
    return systems


def _chosen(systems: Shown | Iterable[Shown] | None) -> dict[str, System]:
    """Returns the systems to export by name."""
    if systems is None:
        return gallery()
    several = [systems] if isinstance(systems, Shown) else list(_iterated(systems))
    names = [shown for shown in several if isinstance(shown, str)]
    known = gallery(names) if names else {}
    chosen: dict[str, System] = {}
    for shown in several:
        if isinstance(shown, str):
            if shown not in known:
                raise BadInput(
                    "graph", "", f"no system named '{shown}'; {_suggestion(shown, known)}"
                )
            chosen[shown] = known[shown]
        elif isinstance(shown, System):
            name = _file_name(shown)
            if name in chosen:
                problem = f"expected systems with different names, got two '{name}'"
                raise BadInput("graph", "", problem)
            chosen[name] = shown
        else:
            raise _unexpected(shown)
    return chosen


def _iterated(systems: Iterable[Shown]) -> Iterable[Shown]:
    try:
        return iter(systems)
    except TypeError:
        raise _unexpected(systems) from None


def _unexpected(shown: object) -> BadInput:
    problem = f"expected the name of a system, a system, or several, got {type(shown).__name__}"
    return BadInput("graph", "", problem)


def _camel_words(name: str) -> list[str]:
    """Returns the words of a name in any spelling."""
    return re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+", name)


def _file_name(system: System) -> str:
    return re.sub(r"\W+", "_", label(system))


def _suggestion(name: str, systems: Mapping[str, System]) -> str:
    """Returns a clause with the system of the most similar name or class, and all names.

    Words may be in another order, in capitals, or joined by another character.
    """
    spellings = {_sorted_words(type(system).__name__): own for own, system in systems.items()}
    spellings |= {_sorted_words(own): own for own in systems}
    close = difflib.get_close_matches(_sorted_words(name[:100]), spellings, n=1, cutoff=0.5)
    return nearest(spellings[close[0]] if close else name, systems)


def _sorted_words(name: str) -> str:
    """Returns the words of a name without `system`, in lower case and sorted."""
    return " ".join(sorted({word.lower() for word in _camel_words(name)} - {"system"}))


def _drawn(dot: bytes, form: str) -> bytes:
    """Returns the drawing by Graphviz; empty if Graphviz is missing or fails."""
    command = shutil.which("dot")
    if command is None:
        return b""
    try:
        return subprocess.run(
            [command, f"-T{form}"],
            input=dot,
            capture_output=True,
            check=True,
            timeout=DOT_TIMEOUT_S,
        ).stdout
    except (OSError, subprocess.SubprocessError):
        return b""

"""Files with the page and the graphs of each diagram and system."""

import difflib
import re
import shutil
import subprocess
from collections.abc import Collection, Iterable, Mapping
from os import PathLike
from pathlib import Path

from pydrake.systems.framework import System

from aerodrake.gallery.graph import systems_by_name, to_dot, to_mermaid
from aerodrake.gallery.system_page import system_page
from aerodrake.scenario import (
    FixedAxis,
    JointDegraded,
    LearnerPoisoned,
    MpcMissed,
    Push,
    ReferenceNan,
    Residual,
    RotorDegraded,
    SampleNan,
    Scenario,
)
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.files import write_atomically

MOST_DEPTH = 100
"""Largest number of levels of diagrams to open."""

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

    They are `NAME.md`, `NAME.dot` and `NAME.mmd`, with Graphviz also `NAME.svg` and `NAME.png`.
    Pages link to each other if one call writes them.

    Args:
        systems: A name such as `closed_loop`, `station`, `coordinator` or `mpc`, a Diagram or
            LeafSystem with a name, or several of them; None for all systems of the package.
        out: Folder, created if missing.
        depth: Number of levels of diagrams to open.

    Raises:
        BadInput: if a name is unknown, `systems` or `depth` are invalid, or `out` cannot be
            written.
    """
    if isinstance(depth, bool) or not isinstance(depth, int) or not 0 <= depth <= MOST_DEPTH:
        problem = f"expected a whole number in [0, {MOST_DEPTH}], got {depth!r}"
        raise BadInput("depth", "", problem)
    chosen = _chosen(systems)
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [path for name in chosen for path in export(name, chosen[name], folder, depth)]
    except OSError as error:
        raise BadInput(folder, "", f"cannot be written: {error.strerror}") from None


def export(name: str, system: System, folder: Path, depth: int) -> list[Path]:
    """Writes `NAME.md`, `.dot`, `.mmd`, with Graphviz also `.svg` and `.png`; returns the paths."""
    dot = to_dot(system, depth)
    contents = {
        "md": system_page(name, system, depth).encode(),
        "dot": dot.encode(),
        "mmd": to_mermaid(system, depth).encode(),
    }
    contents |= {suffix: _drawn(dot, suffix) for suffix in ("svg", "png")}
    written = []
    for suffix, content in contents.items():
        if content:
            written.append(folder / f"{name}.{suffix}")
            write_atomically(written[-1], content)
    return written


def gallery(names: Collection[str] = ()) -> dict[str, System]:
    """Returns all diagrams and systems by name, from the default scenario if it has them.

    Other scenarios have the systems of the orientation task, of faults and of CLIK. They are
    built if one of `names` is missing, or if `names` is empty.
    """
    in_station = (SampleNan(), RotorDegraded(), JointDegraded(), Push())
    faults = (*in_station, MpcMissed(), LearnerPoisoned(), ReferenceNan())
    all_tasks = Scenario(orientation=FixedAxis(), faults=faults, residual=Residual(mode="online"))
    systems: dict[str, System] = {}
    for scenario in (Scenario(), all_tasks, Scenario(controller="clik")):
        for name, system in systems_by_name(make_closed_loop(scenario)).items():
            systems.setdefault(name, system)
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
            chosen[_file_name(shown)] = shown
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


def _file_name(system: System) -> str:
    """Returns the name of a system as a word; that of its class if it has none."""
    name = system.get_name()
    if not name or "@" in name:  # Drake's default names contain an address.
        name = type(system).__name__
    return re.sub(r"\W+", "_", name)


def _suggestion(name: str, systems: Mapping[str, System]) -> str:
    """Returns a clause with the system of the most similar name or class, and all names.

    Words may be in another order, in capitals, or joined by another character.
    """
    spellings = {_words(type(system).__name__): own for own, system in systems.items()}
    spellings |= {_words(own): own for own in systems}
    close = difflib.get_close_matches(_words(name[:100]), spellings, n=1, cutoff=0.5)
    return nearest(spellings[close[0]] if close else name, systems)


def _words(name: str) -> str:
    """Returns the sorted words of a name in any spelling, without `system`."""
    words = re.findall(r"[A-Z]?[a-z]+|[A-Z]+|[0-9]+", name)
    return " ".join(sorted({word.lower() for word in words} - {"system"}))


def _drawn(dot: str, suffix: str) -> bytes:
    """Returns the drawing by Graphviz; empty if Graphviz is missing or fails."""
    command = shutil.which("dot")
    if command is None:
        return b""
    try:
        return subprocess.run(
            [command, f"-T{suffix}"],
            input=dot.encode(),
            capture_output=True,
            check=True,
            timeout=DOT_TIMEOUT_S,
        ).stdout
    except (OSError, subprocess.SubprocessError):
        return b""

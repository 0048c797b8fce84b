"""Files with the page and the graphs of each diagram and system."""

import shutil
import subprocess
from collections.abc import Collection, Iterable, Mapping
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

DOT_TIMEOUT_S = 60.0
"""Time limit of Graphviz, which needs less than a second for the closed loop."""


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


def export_all(
    systems: Mapping[str, System], names: Iterable[str], folder: Path, depth: int
) -> list[Path]:
    """Exports the systems with these names, or all if there are none; returns the paths.

    Args:
        systems: Diagrams and leaf systems by name, from `gallery` or `systems_by_name`.
        names: Keys of `systems`.
        folder: The folder, created if missing.
        depth: Number of levels of diagrams to open.

    Raises:
        BadInput: if a name is unknown, or the folder cannot be written.
    """
    names = list(names) or list(systems)
    for name in names:
        if name not in systems:
            raise BadInput("graph", "", f"no system named '{name}'; {nearest(name, systems)}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [path for name in names for path in export(name, systems[name], folder, depth)]
    except OSError as error:
        raise BadInput(folder, "", f"cannot be written: {error.strerror}") from None


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

"""The page and the graphs of each diagram and system, as files."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

from pydrake.systems.framework import Diagram, System

from aerodrake.errors import BadInput, nearest
from aerodrake.files import write_whole
from aerodrake.graph import systems_by_name, to_dot, to_mermaid
from aerodrake.system_page import system_page

DOT_TIMEOUT_S = 60.0
"""Graphviz lays out the closed loop in well under a second."""


def export(name: str, system: System, folder: Path, depth: int) -> list[Path]:
    """Writes `NAME.md`, `.dot` and `.mmd`; and `.svg` and `.png` where Graphviz is there.

    Returns:
        The paths written.
    """
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
            write_whole(written[-1], content)
    return written


def export_all(closed_loop: Diagram, names: Iterable[str], folder: Path, depth: int) -> list[Path]:
    """Exports the named systems of a closed loop, or all of them if none is named.

    Args:
        closed_loop: Of `make_closed_loop`.
        names: Of diagrams and leaf systems, as on the wiring page.
        folder: Created if missing.
        depth: Levels of diagrams to open.

    Returns:
        The paths written.

    Raises:
        BadInput: if a name is unknown, or the folder cannot be written.
    """
    systems = systems_by_name(closed_loop)
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
    """Graphviz's drawing; empty where Graphviz is missing or fails."""
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

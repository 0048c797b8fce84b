"""`aerodrake graph [NAME]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from aerodrake.commands.options import whole_number

HELP = "draw diagrams"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    command.add_argument(
        "name", nargs="?", help="closed_loop, station, coordinator or a system; default: all"
    )
    command.add_argument("--out", type=Path, default=Path("graphs"), metavar="DIR")
    command.add_argument(
        "--depth", type=whole_number(0, 100), default=2, metavar="N", help="levels of nesting"
    )


def main(arguments: argparse.Namespace) -> int:
    """Writes pages and graphs of the closed loop, its two sides, or single systems."""
    from aerodrake.gallery.export import export_all, gallery

    names = [arguments.name] if arguments.name else []
    for path in export_all(gallery(names), names, arguments.out, arguments.depth):
        print(path)
    return 0

"""Command `aerodrake graph [NAME]`."""

import argparse
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.limits import DEPTH

HELP = "export diagrams and systems as graphs and pages"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    command.add_argument(
        "name", nargs="?", help="closed_loop, station, coordinator or a system; default: all"
    )
    command.add_argument(
        "--out", type=Path, default=Path("graphs"), metavar="DIR", help="folder; default: graphs"
    )
    command.add_argument(
        "--depth",
        type=options.whole_number(*DEPTH),
        default=2,
        metavar="N",
        help="levels of nested diagrams; default: 2",
    )


def main(arguments: argparse.Namespace) -> int:
    """Exports the closed loop, station, coordinator or single systems as graphs and pages."""
    from aerodrake.gallery.export import graph

    for path in graph(arguments.name, arguments.out, arguments.depth):
        print(path)
    return 0

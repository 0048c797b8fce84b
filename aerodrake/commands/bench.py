"""Command `aerodrake bench`."""

import argparse
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.errors import BadInput
from aerodrake.support.files import write_atomically
from aerodrake.support.run_folder import run_folder

HELP = "measure computation times and memory"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    command.add_argument("--quick", action="store_true", help="shorter flights, fewer repetitions")
    command.add_argument(
        "--json", type=Path, metavar="FILE", help="also write bench.json to FILE; replaces it"
    )
    options.add_output(command, "runs/bench-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Measures the MPC's tick beside other solvers, the closed loop beside its plant, and memory.

    Skips solvers that are not installed; pip install aerodrake[bench] installs them.
    """
    file = arguments.json
    if file is not None and (file.is_dir() or not file.parent.is_dir()):
        raise BadInput("json", "", f"expected a file in an existing folder, got {file}")
    target = arguments.out or options.new_folder("bench")

    from aerodrake.api.console import Console
    from aerodrake.bench.figure import plot_bench
    from aerodrake.bench.report import FILES, bench_table, missing_peers
    from aerodrake.bench.suite import FULL, QUICK, STEPS, bench
    from aerodrake.flight.summary import to_json
    from aerodrake.reports.drawing import drawing

    console = Console(arguments.quiet)
    console.note(missing_peers())
    with run_folder(target, FILES[:1]) as folder:
        with console.bar(None, STEPS, "step") as bar:

            def begin(step: str) -> None:
                bar.set_description(step)
                bar.update()

            figures = bench(QUICK if arguments.quick else FULL, begin)
        (folder / FILES[0]).write_text(to_json(figures), encoding="utf-8")
    path = target / FILES[1]
    with drawing(path):
        plot_bench(figures, path)
    if file is not None:
        write_atomically(file, to_json(figures).encode())
    console.say(bench_table(figures))
    console.say(f"\n{target}: {', '.join(FILES)}")
    return 0

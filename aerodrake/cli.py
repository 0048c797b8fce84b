"""Command line `aerodrake COMMAND`; see `aerodrake --help`."""

import argparse
import sys
from collections.abc import Sequence

from aerodrake.commands import (
    analyze,
    bench,
    budget,
    compare,
    coordinator,
    graph,
    identify,
    mount,
    run,
    sweep,
    train,
)
from aerodrake.support.errors import BadInput, ProcessDied
from aerodrake.support.interrupts import termination_as_interrupt
from aerodrake.support.streams import output_streams
from aerodrake.support.version import __version__

_MODULES = (run, mount, coordinator, analyze, compare, identify, train, sweep, budget, graph, bench)
COMMANDS = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
"""Commands by name, in the order of `aerodrake --help`."""

EXIT_CODES = """Exit codes: 0 success; 1 a flight did not complete, a closed loop is unstable, a
variant failed, a process died or standard output cannot be written; 2 bad input; 130
interrupted; 141 standard output has no reader. Results are written even if standard output or
standard error cannot be."""


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command and returns one of the `EXIT_CODES`, that of the first cause.

    An error of standard error has no exit code, and an interrupt of a flight alone is no error.
    """
    with output_streams() as output:
        try:
            code = _run(argv)
        except SystemExit as end:  # After --help, --version or an error of an option.
            raise SystemExit(output.exit_code(end.code)) from None
        return output.exit_code(code)


def _run(argv: Sequence[str] | None) -> int:
    arguments = make_parser().parse_args(argv)
    try:
        with termination_as_interrupt():
            return arguments.command(arguments)
    except (BadInput, ProcessDied) as error:
        print(f"aerodrake: {_as_given(error, arguments)}", file=sys.stderr)
        return 2 if isinstance(error, BadInput) else 1
    except KeyboardInterrupt:
        print("aerodrake: interrupted", file=sys.stderr)
        return 130


def make_parser() -> argparse.ArgumentParser:
    """Returns the parser of all commands; its result has the command's function as `command`."""
    parser = _Parser(
        prog="aerodrake",
        description="Predictive kinematic control of aerial manipulators as a Drake diagram.",
        epilog=EXIT_CODES,
    )
    parser.add_argument("--version", action="version", version=f"aerodrake {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, module in COMMANDS.items():
        command = commands.add_parser(name, help=module.HELP, description=module.main.__doc__)
        module.add_arguments(command)
        command.set_defaults(command=module.main)
    return parser


def _as_given(error: Exception, arguments: argparse.Namespace) -> str:
    """Returns the message, in which an argument of a function is named as the option it is here."""
    names = vars(arguments).keys() - {getattr(arguments, "scenario", None)}
    if not (isinstance(error, BadInput) and error.source in names):
        return str(error)
    return str(error).replace(error.source, f"--{error.source.replace('_', '-')}", 1)


class _Parser(argparse.ArgumentParser):
    """Parser that prints errors in one line, as for all other bad input."""

    def error(self, message: str) -> None:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")

"""Command `aerodrake mount ARM.urdf`."""

import argparse
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.limits import BASE_KG, POSE, ROTOR_RADIUS_M, ROTORS, SCALE, THRUST_N

HELP = "make a vehicle and a scenario for an arm from its own URDF"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    command.add_argument("urdf", type=Path, metavar="ARM.urdf", help="URDF of the arm alone")
    command.add_argument("--tool", default="", metavar="LINK", help="link of the tool")
    command.add_argument(
        "--root",
        default="",
        metavar="LINK",
        help="link of the arm that is mounted, without the links above it; default: the first one",
    )
    command.add_argument(
        "--scale",
        nargs="+",
        type=options.number_in(*SCALE),
        default=[1.0],
        metavar="FACTOR",
        help="factor of all lengths of the arm, with which masses are scaled by its cube; or "
        "factors of lengths and masses",
    )
    command.add_argument(
        "--mount",
        nargs="+",
        type=options.number_in(*POSE),
        default=[],
        metavar="NUMBER",
        help="position x y z of the arm's first link in the base's frame in m, and if need be its "
        "roll, pitch and yaw in rad; default: below the base",
    )
    for option, kind, metavar, text in (
        ("--base-mass", options.number_in(*BASE_KG), "KG", "mass of all but the arm"),
        ("--rotors", options.whole_number(*ROTORS), "N", "number of rotors, even"),
        ("--rotor-radius", options.number_in(*ROTOR_RADIUS_M), "M", "radius of their circle"),
        ("--max-thrust", options.number_in(*THRUST_N), "NEWTON", "largest thrust of each"),
    ):
        command.add_argument(
            option, type=kind, metavar=metavar, help=f"{text}; default: chosen for the arm"
        )
    command.add_argument(
        "--package-path",
        action="append",
        default=[],
        metavar="DIR",
        help="folder of a ROS package, or that contains some, for package:// names of meshes; may "
        "be given several times; the folders above the URDF are searched as well",
    )
    options.add_output(command, "the name of the file without .urdf; replaces earlier results")


def main(arguments: argparse.Namespace) -> int:
    """Makes a multirotor for an arm, writes the vehicle and its scenario, and lets it hover.

    The exit code is 1 if the closed loop is unstable or the hover is not completed.
    """
    from aerodrake.api.console import Console
    from aerodrake.api.mount import mount

    given = {name: value for name, value in vars(arguments).items() if name != "command"}
    result = mount(**given)
    folder = result.scenario.parent
    files = ", ".join(sorted(path.name for path in folder.iterdir()))
    again = f"fly it: aerodrake run {result.scenario}"
    Console(arguments.quiet).say(f"{result}\n\n{folder}: {files}\n{again}")
    return 0 if result.flies else 1

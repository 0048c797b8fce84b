"""Mounting of an arm below a multirotor."""

import os
from collections.abc import Sequence
from pathlib import Path

from aerodrake.api.analyze import analyze
from aerodrake.api.console import Console
from aerodrake.api.fly import fly
from aerodrake.api.mount_result import MountResult
from aerodrake.mounting.folder import write_vehicle
from aerodrake.mounting.request import Request
from aerodrake.mounting.sizing import Given
from aerodrake.support.arguments import checked

HOVER = {"reference": {"kind": "hover"}, "settle_s": 1.0, "duration": 2.0}
"""Keys of the flight that shows that the vehicle hovers."""
PUSH, LARGEST_PUSH_N, PUSH_S = 0.05, 200.0, 0.2
"""Push to the base at the start of the reference: its force over the vehicle's weight, largest
force in N, and duration in s."""


@checked
def mount(
    urdf: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    tool: str = "",
    root: str = "",
    scale: float | Sequence[float] = 1.0,
    mount: Sequence[float] = (),
    base_mass: float | None = None,
    rotors: int | None = None,
    rotor_radius: float | None = None,
    max_thrust: float | None = None,
    package_path: Sequence[str | os.PathLike[str]] = (),
    quiet: bool = False,
) -> MountResult:
    """Mounts an arm below a multirotor, and writes the vehicle and a scenario that flies it.

        vehicle = aerodrake.mount("panda.urdf", scale=0.4)
        aerodrake.fly(vehicle.scenario)

    All that is not given is chosen for the arm's mass and reach. The loop is then linearised, and
    the vehicle hovers for three seconds, with a push to its base.

    Args:
        urdf: URDF of the arm alone, as its maker publishes it.
        out: Folder of the results; None for the name of the file without `.urdf`. Earlier results
            in it are replaced as a whole.
        tool: Link of the tool; empty to guess it.
        root: Link of the arm that is mounted, without the links above it; empty for the first one.
        scale: Factor of all lengths of the arm, with which masses are scaled by its cube; or
            factors of lengths and masses.
        mount: Position of the arm's first link in the base's frame in m, if need be with roll,
            pitch and yaw in rad; empty to choose it.
        base_mass: kg, of all but the arm.
        rotors: Number of rotors, even.
        rotor_radius: m, of the circle on which the rotors are.
        max_thrust: N, largest thrust of each rotor.
        package_path: Folders of ROS packages, or folders that contain them, for `package://`.
        quiet: True to print no notes and show no progress.

    Raises:
        BadInput: if the URDF is not that of an arm, an argument is invalid, or the folder cannot
            be written.
    """
    console = Console(quiet)
    request = Request(
        urdf=Path(urdf),
        tool=tool,
        root=root,
        scale=tuple(scale) if isinstance(scale, Sequence) else (scale,),
        mount=tuple(mount),
        packages=tuple(map(Path, package_path)),
        given=Given(base_mass, rotors, rotor_radius, max_thrust),
    )
    folder = Path(request.name if out is None else out)
    with console.bar(f"mount {request.name}", 1, "arm") as bar:
        mounted = write_vehicle(request, folder)
        bar.update()
    path = folder / f"{request.name}.yaml"
    push_n = min(PUSH * mounted.weight, LARGEST_PUSH_N)
    force = {"force_n": [push_n, 0.0, 0.0]}
    push = {"kind": "push", "start_s": 0.0, "duration_s": PUSH_S, **force}
    analysis = analyze(path, quiet=quiet)
    with console.bar(f"hover {request.name}", 1, "flight") as bar:
        # Its notes are those of the analysis.
        hover = fly(path, {**HOVER, "faults": [push]}, quiet=True)
        bar.update()
    return MountResult(
        scenario=path,
        changes=mounted.changes,
        choices=mounted.choices,
        analysis=analysis,
        push_n=push_n,
        hover=hover,
    )

"""Real arms of the package `example-robot-data`, mounted and flown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

from aerodrake.analysis.analyze import analyze_loop
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import rounded, summarize
from aerodrake.mounting.folder import write_vehicle
from aerodrake.mounting.request import Request
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput
from aerodrake.support.threads import single_thread
from aerodrake.support.version import __version__

PACKAGE = "example-robot-data"


@dataclass(frozen=True)
class RobotArm:
    """An arm of the package.

    Attributes:
        name: Name in the table, and of its folder.
        urdf: End of the path of its URDF.
        root: Link that is mounted, of a robot that is more than the arm; else empty.
        tool: Link of the tool, where another one is as likely; else empty.
    """

    name: str
    urdf: str
    root: str = ""
    tool: str = ""


ARMS = (
    RobotArm("Panda", "panda_description/urdf/panda.urdf"),
    RobotArm("xArm7", "xarm_description/urdf/xarm7.urdf"),
    RobotArm("UR3", "ur_description/urdf/ur3_robot.urdf"),
    RobotArm("UR5", "ur_description/urdf/ur5_robot.urdf"),
    RobotArm("UR10", "ur_description/urdf/ur10_robot.urdf"),
    RobotArm("Jaco", "kinova_description/robots/kinova.urdf"),
    RobotArm("Z1", "z1_description/urdf/z1.urdf"),
    RobotArm("SO-100", "so_arm_description/urdf/so100.urdf"),
    RobotArm("SO-101", "so_arm_description/urdf/so101.urdf"),
    RobotArm("Talos, left", "talos_data/robots/talos_left_arm.urdf"),
    RobotArm(
        "Baxter, right",
        "baxter_description/urdf/baxter.urdf",
        root="right_arm_mount",
        tool="right_gripper",
    ),
    RobotArm("TwoDofs", "asr_twodof_description/urdf/TwoDofs.urdf"),
)


def installed_urdf(arm: RobotArm) -> Path:
    """Returns the path of an arm's URDF in the installed package, wherever its files are.

    Raises:
        BadInput: if the package is not installed, or does not have the file.
    """
    try:
        paths = files(PACKAGE) or []
    except PackageNotFoundError:
        expected = "expected the extra [robots]: pip install 'aerodrake[robots]'"
        raise BadInput("robots", "", expected) from None
    for path in paths:
        if path.match(arm.urdf):
            return Path(path.locate())
    raise BadInput("robots", "", f"expected {arm.urdf} in {PACKAGE}, which does not have it")


def robots_figures(
    arms: Sequence[RobotArm], folder: Path, flown_s: float, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Mounts arms with the default choices and flies their clovers.

    Args:
        arms: The arms.
        folder: Existing folder of the vehicles.
        flown_s: Longest reference time of each flight.
        progress: Called with the name of each arm at its start.

    Returns:
        The version, and for each arm the keys of `robot_figures`.

    Raises:
        BadInput: as for `installed_urdf` and `write_vehicle`.
    """
    paths = [installed_urdf(arm) for arm in arms]
    rows = []
    for arm, path in zip(arms, paths, strict=True):
        progress(arm.name)
        rows.append(robot_figures(arm, path, folder, flown_s))
    return {"version": __version__, "arms": rows}


def robot_figures(arm: RobotArm, urdf: Path, folder: Path, flown_s: float) -> dict[str, Any]:
    """Mounts one arm, analyses its closed loop in hover, and flies the scenario of its vehicle.

    Keys:
        name, joints: Of the arm.
        arm_kg, base_kg: Masses.
        reach_m: Length of the arm from its first joint to the tool, stretched.
        exit_reason, exit_cause, error: Of the flight, as in its summary.
        torque_at_limit: Largest share of the time that a joint's torque is at its limit.
        is_stable: True if the loop is stable in hover.
        delay_margin_s: Additional delay of the base's measurements at which the loop becomes
            unstable; null if there is none in the range of the search.
    """
    folder = folder / arm.name.replace(", ", "_").lower()
    request = Request(urdf, root=arm.root, tool=arm.tool)
    vehicle = write_vehicle(request, folder).vehicle
    scenario = load_scenario(str(folder / f"{request.name}.yaml"))
    scenario = replace(scenario, duration=min(scenario.duration, flown_s))
    analysis = analyze_loop(scenario)
    delay = next(margin for margin in analysis.margins if margin.name == "base_delay").upper
    with single_thread():
        summary = summarize(scenario, FlightSimulation(scenario).fly())
    shares = summary["arm"]["torque_at_limit"]
    return {
        "name": arm.name,
        "joints": len(shares),
        "arm_kg": rounded(vehicle.arm.mass),
        "base_kg": rounded(vehicle.multirotor.mass),
        "reach_m": rounded(vehicle.arm.reach(vehicle.tool.link)),
        "exit_reason": summary["exit_reason"],
        "exit_cause": summary["exit_cause"],
        "error": summary["error"],
        "torque_at_limit": max(shares.values()),
        "is_stable": analysis.is_stable,
        "delay_margin_s": None if delay is None else rounded(delay.value),
    }

"""Mounting of an arm below a multirotor: from the arm's URDF to a vehicle and its scenario."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from scipy.stats.qmc import Halton

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.robot import BASE_FRAME, RobotDescription, make_nominal_plant
from aerodrake.model.vehicle.tucking import CLEARANCE_M, GroundGeometry, tuck
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.mounting.airframe import MOUNT_DEPTH
from aerodrake.mounting.arm import Pose
from aerodrake.mounting.arm_urdf import read_arm
from aerodrake.mounting.convert import convert
from aerodrake.mounting.meshes import write_meshes
from aerodrake.mounting.posture import Postures
from aerodrake.mounting.request import PLACE, TURNED, Request
from aerodrake.mounting.scenario_yaml import Start, scenario_yaml
from aerodrake.mounting.sizing import Multirotor
from aerodrake.mounting.tool import Tool
from aerodrake.mounting.vehicle_urdf import VehicleDesign
from aerodrake.mounting.working import Working, WorkingSearch
from aerodrake.support.errors import BadInput
from aerodrake.support.urdf import SUFFIX

LEAST_HEIGHT, LEAST_CLEARANCE = 1.5, 1.0
"""Smallest initial height of the base, and of the lowest part of the vehicle, in m."""
SPARE_M = 0.02
"""Room between a tucked arm and the height that a landing needs."""
LEANING = 0.02
"""Mean height of the tool over its distance from the first joint, above which an arm stands."""
SAMPLES = 64
"""Number of configurations for that mean, and twice the weight of the one with joints at zero."""


@dataclass(frozen=True)
class Mounted:
    """Mounted arm.

    Attributes:
        vehicle: The vehicle.
        working: The arm's working configuration.
        start: The start of a flight.
        joints: Names of the joints, from the base to the tool.
        changes: Sentences on changes of the arm's URDF.
        choices: Sentences on what was chosen.
    """

    vehicle: VehicleDesign
    working: Working
    start: Start
    joints: tuple[str, ...]
    changes: tuple[str, ...]
    choices: tuple[str, ...] = ()


def mount_arm(request: Request, folder: Path) -> Mounted:
    """Writes NAME.urdf, NAME.yaml and NAME-meshes for an arm into a folder.

    Raises:
        BadInput: if the arm cannot be read or converted, or cannot hold itself.
        OSError: if a file cannot be written.
    """
    read = read_arm(request.urdf, request.packages)
    tool = Tool.of(read.arm, request.tool)
    scales = {"length": request.length, "mass": request.mass}
    converted = convert(read, tool.link, root=request.root, **scales)
    tool = replace(tool, link=converted.tool, position=request.length * tool.position)
    arm, more = write_meshes(converted.arm, folder / f"{request.name}-meshes")
    arm = replace(arm, name=request.name)

    path = folder / f"{request.name}{SUFFIX}"
    multirotor = Multirotor.for_arm(arm.mass, arm.reach(tool.link), request.given)
    vehicle = VehicleDesign(arm, tool, multirotor, Pose(), is_filtered=False)
    vehicle = replace(vehicle, mount=_mount(vehicle, request.mount, path))
    working = _find_working(vehicle, path)
    _check_torques(working, converted.joints, request.urdf)
    if not request.mount:
        vehicle = replace(vehicle, mount=_turned(vehicle.mount, working))
    vehicle, start = _completed(vehicle, working, path)
    changes = (*converted.changes, *more)
    mounted = Mounted(vehicle, working, start, converted.joints, changes)
    mounted = replace(mounted, choices=tuple(_sentences(mounted, request)))
    path.write_text(vehicle.urdf((*mounted.choices, *changes)), encoding="utf-8")
    text = scenario_yaml(request, vehicle.multirotor, working, start)
    path.with_suffix(".yaml").write_text(text, encoding="utf-8")
    return mounted


def _plant(vehicle: VehicleDesign, path: Path) -> tuple[MultibodyPlant, SceneGraph]:
    """Writes a vehicle's URDF and returns the plant that is read from it, with its SceneGraph."""
    path.write_text(vehicle.urdf(), encoding="utf-8")
    return make_nominal_plant(RobotDescription.read(str(path)))


def _mount(vehicle: VehicleDesign, given: tuple[float, ...], path: Path) -> Pose:
    """Returns the pose of the arm: upside down, unless it hangs from its first link already."""
    if len(given) == TURNED:
        return Pose(given[:PLACE], given[PLACE:])
    depth = MOUNT_DEPTH * vehicle.multirotor.scale
    xyz = given or (0.0, 0.0, -round(depth, 3))
    plant, _ = _plant(vehicle, path)
    postures = Postures(plant)
    spread = Halton(len(postures.lower), scramble=False).random(SAMPLES)
    sampled = postures.lower + spread * (postures.upper - postures.lower)
    zero = np.clip(np.zeros(len(postures.lower)), postures.lower, postures.upper)
    first = vehicle.arm.moving(vehicle.tool.link)[0].child
    shoulder = vehicle.arm.poses()[first].translation()
    configurations = (*sampled, *[zero] * (SAMPLES // 2))
    tools = np.array([postures.at(q).tool - shoulder for q in configurations])
    height = tools[:, 2].mean() / np.linalg.norm(tools, axis=1).mean()
    return Pose(xyz, (math.pi, 0.0, 0.0) if height > LEANING else (0.0, 0.0, 0.0))


def _find_working(vehicle: VehicleDesign, path: Path) -> Working:
    plant, scene_graph = _plant(vehicle, path)
    mount = np.array(vehicle.mount.xyz)
    postures = Postures(plant)
    reach = Kinematics(plant).farthest_reach(mount, postures.lower, postures.upper)
    return WorkingSearch(plant, scene_graph, mount, reach).run()


def _turned(mount: Pose, working: Working) -> Pose:
    """Returns the pose turned about the vertical, so that the tool is in front, along y."""
    x, y = working.posture.tool[:2] - mount.xyz[:2]
    yaw = math.pi / 2 - math.atan2(y, x) if math.hypot(x, y) > 1e-3 else 0.0
    return mount._replace(rpy=(*mount.rpy[:2], round(math.remainder(yaw, math.tau), 4)))


def _check_torques(working: Working, joints: tuple[str, ...], source: Path) -> None:
    """Raises BadInput if a joint cannot hold the arm in the working configuration."""
    if working.torque > 1:
        joint = joints[int(np.argmax(working.torques))]
        problem = "expected an effort limit with which it holds the arm in some configuration"
        got = f"got one of which it needs {working.torque:.0%} in the best one"
        raise BadInput(source, f"joint {joint}", f"{problem}, {got}")


def _completed(vehicle: VehicleDesign, working: Working, path: Path) -> tuple[VehicleDesign, Start]:
    """Returns the vehicle with legs on which it can land, and the start of its flights."""
    plant, scene_graph = _plant(vehicle, path)
    ground = GroundGeometry(plant, scene_graph, BASE_FRAME)
    tucked = ground.heights(tuck(ground, working.q)).min(initial=0.0)
    multirotor = vehicle.multirotor
    feet = max(multirotor.feet, round(CLEARANCE_M + SPARE_M - float(tucked), 2))
    multirotor = replace(multirotor, feet=feet)
    lowest = max(feet, -float(ground.heights(working.q).min(initial=0.0)))
    height = max(LEAST_HEIGHT, math.ceil(10 * (lowest + LEAST_CLEARANCE)) / 10)
    kinematics = Kinematics(plant)
    tool, _ = kinematics.tool(working.q)
    total = plant.CalcTotalMass(plant.CreateDefaultContext())
    start = Start(
        height=height,
        clearance=height - lowest,
        reach=kinematics.farthest_reach(tool, ground.lower, ground.upper),
        hover=total * GRAVITY / (multirotor.rotors * multirotor.max_thrust),
    )
    return replace(vehicle, multirotor=multirotor, is_filtered=True), start


def _sentences(mounted: Mounted, request: Request) -> Iterator[str]:
    """Yields sentences on what was chosen."""
    vehicle, working = mounted.vehicle, mounted.working
    multirotor, tool, mount = vehicle.multirotor, vehicle.tool, vehicle.mount
    yield f"arm: {len(mounted.joints)} joints, {vehicle.arm.mass:.3g} kg"
    axis = " ".join(f"{x:.3g}" for x in tool.direction)
    yield f"tool: link {tool.link} ({tool.reason}), pointing along ({axis}) of its frame"
    if not request.mount:
        way = "upside down" if mount.rpy[0] else "upright, since it hangs down like this"
        yield f"mount: {-mount.xyz[2]:g} m below the base's origin, {way}, tool in front (y)"
    yield (
        f"multirotor: {multirotor.mass:g} kg, {multirotor.rotors} rotors of up to "
        f"{multirotor.max_thrust:g} N on a circle of {multirotor.radius:g} m; hover takes "
        f"{mounted.start.hover:.0%} of their thrust"
    )
    yield "rotors: as fast as the packaged 17 inch ones; larger ones are slower (vehicle.rotor)"
    yield f"legs: {multirotor.feet:.2f} m deep, so that the vehicle can land with its arm tucked"
    yield from (f"working configuration: {line}" for line in working.lines())
    joint, ratio = mounted.joints[working.weakest[0]], working.weakest[1]
    if ratio > 1:
        yield f"caution: {joint} cannot hold the arm everywhere: up to {ratio:.0%} of its effort"
    if working.overlap:
        links = " and ".join(working.overlap.links)
        yield f"caution: boxes of {links} overlap by {1000 * working.overlap.depth:.0f} mm there"

"""Mounting of an arm below a multirotor: from the arm's URDF to a vehicle and its scenario."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.robot import BASE_FRAME, RobotDescription, make_nominal_plant
from aerodrake.model.vehicle.tucking import CLEARANCE_M, GroundGeometry, tuck
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.mounting.airframe import MOUNT_DEPTH
from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.arm_urdf import read_arm
from aerodrake.mounting.convert import convert
from aerodrake.mounting.meshes import write_meshes
from aerodrake.mounting.mounted import Mounted, choices
from aerodrake.mounting.pose import Pose
from aerodrake.mounting.posture import Postures
from aerodrake.mounting.request import PLACE, Request
from aerodrake.mounting.scenario_yaml import Start, scenario_yaml
from aerodrake.mounting.sizing import Multirotor
from aerodrake.mounting.tool import Tool
from aerodrake.mounting.vehicle_urdf import VehicleDesign
from aerodrake.mounting.working import Working, WorkingSearch
from aerodrake.support.errors import BadInput
from aerodrake.support.limits import THRUST_N
from aerodrake.support.urdf import SUFFIX

LEAST_HEIGHT, LEAST_CLEARANCE = 1.5, 1.0
"""Smallest initial height of the base, and of the lowest part of the vehicle, in m."""
LARGEST_SHARE = 0.8
"""Largest thrust in hover over the largest thrust, with given rotors."""
SPARE_M = 0.02
"""Room between a tucked arm and the height that a landing needs."""
ATTITUDES = (math.pi, 0.0, 0.0), (0.0, 0.0, 0.0)
"""Roll, pitch and yaw of an arm that is mounted upside down, and as it stands."""


def mount_arm(request: Request, folder: Path) -> Mounted:
    """Writes NAME.urdf, NAME.yaml and NAME-meshes for an arm into a folder.

    Raises:
        BadInput: if the arm cannot be read or converted, or cannot hold itself.
        OSError: if a file cannot be written.
    """
    read = read_arm(request.urdf, request.packages)
    tool = Tool.of(read.arm, request.tool)
    options = {"root": request.root, "length": request.length, "mass": request.mass}
    converted = convert(read, tool.link, source=request.urdf, **options)
    tool = replace(tool, link=converted.tool, position=request.length * tool.position)
    arm, more = write_meshes(converted.arm, folder / f"{request.name}-meshes")
    arm = replace(arm, name=request.name)

    path = folder / f"{request.name}{SUFFIX}"
    vehicle, working = _sized(arm, tool, request, path)
    _check_torques(working, converted.joints, request.urdf)
    if len(request.mount) <= PLACE:
        vehicle = replace(vehicle, mount=_turned(vehicle.mount, working))
    vehicle, start = _completed(vehicle, working, path)
    changes = (*converted.changes, *more)
    mounted = Mounted(vehicle, working, start, converted.joints, changes)
    mounted = replace(mounted, choices=tuple(choices(mounted, request)))
    path.write_text(vehicle.urdf((*mounted.choices, *changes)), encoding="utf-8")
    text = scenario_yaml(request, vehicle.multirotor, working, start)
    path.with_suffix(".yaml").write_text(text, encoding="utf-8")
    return mounted


def _plant(vehicle: VehicleDesign, path: Path) -> tuple[MultibodyPlant, SceneGraph]:
    """Writes a vehicle's URDF and returns the plant that is read from it, with its SceneGraph."""
    path.write_text(vehicle.urdf(), encoding="utf-8")
    return make_nominal_plant(RobotDescription.read(str(path)))


def _sized(arm: ArmTree, tool: Tool, request: Request, path: Path) -> tuple[VehicleDesign, Working]:
    """Returns the vehicle with its mount, and the working configuration.

    The configuration is searched for again if the arm's inertia there needs another base.
    """
    size = arm.mass, arm.reach(tool.link), request.given
    multirotor = Multirotor.for_arm(*size)
    _check_thrust(multirotor, arm.mass, request)
    vehicle = VehicleDesign(arm, tool, multirotor, Pose(), is_filtered=False)
    mounted, working = _best(vehicle, request.mount, path)
    sized = Multirotor.for_arm(*size, working.inertia)
    if sized == multirotor:
        return mounted, working
    _check_thrust(sized, arm.mass, request)
    return _best(replace(vehicle, multirotor=sized), request.mount, path)


def _best(
    vehicle: VehicleDesign, given: tuple[float, ...], path: Path
) -> tuple[VehicleDesign, Working]:
    """Returns the vehicle with its mount, and the working configuration.

    Unless it is given, the arm is mounted upside down or as it stands, whichever has the better
    working configuration.
    """
    depth = round(MOUNT_DEPTH * vehicle.multirotor.scale, 3)
    xyz, rpy = given[:PLACE] or (0.0, 0.0, -depth), given[PLACE:]
    mounted = [replace(vehicle, mount=Pose(xyz, turn)) for turn in ([rpy] if rpy else ATTITUDES)]
    options = [(vehicle, _find_working(vehicle, path)) for vehicle in mounted]
    return min(options, key=lambda pair: pair[1].cost)


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


def _check_thrust(multirotor: Multirotor, arm_kg: float, request: Request) -> None:
    """Raises BadInput if rotors cannot carry the vehicle, or are smaller than any."""
    total, most = arm_kg + multirotor.mass, multirotor.rotors * multirotor.max_thrust / GRAVITY
    low, high = THRUST_N
    thrust = min(max(multirotor.max_thrust, low), high)
    if thrust != multirotor.max_thrust:
        expected = f"expected an arm for {multirotor.rotors} rotors of {low:g} to {high:g} N each"
        factor = (request.mass * thrust / multirotor.max_thrust) ** (1 / 3)
        factor *= 0.9 if thrust == high else 1.1
        advice = "mount a part of it with --root, or " if thrust == high else ""
        advice += f"scale it, as with --scale {factor:.2g}"
        problem = f"{expected}, got one of {arm_kg:.4g} kg; {advice}"
        raise BadInput(request.urdf, "", problem)
    if total > LARGEST_SHARE * most:
        expected = f"expected rotors that hover with {LARGEST_SHARE:.0%} of their thrust or less"
        raise BadInput("max_thrust", "", f"{expected}, got {total / most:.0%}")


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

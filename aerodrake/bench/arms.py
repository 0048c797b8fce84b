"""Variants of a robot with other numbers of joints."""

import copy
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from aerodrake.scenario import Scenario
from aerodrake.support.files import locate

LIGHT = "1e-6"
"""kg m^2, inertia of the 5 g links between repeated joints."""


def with_joints(scenario: Scenario, joints: int, robot: Path) -> Scenario:
    """Returns the scenario with an arm of another number of joints, and writes its URDF.

    With fewer joints, those at the tip are fixed at their working angles. With more, the last
    joint is repeated at the same position, with its axis perpendicular to the one before. The
    working position of the end-effector is unchanged.

    Args:
        scenario: Gives the robot.
        joints: Number of joints, 1 or more.
        robot: Path of the new URDF.
    """
    ElementTree.register_namespace("drake", "https://drake.mit.edu")
    tree = ElementTree.parse(locate(scenario.vehicle.robot))
    root, working = tree.getroot(), scenario.vehicle.working_rad
    arm = root.findall("joint[@type='revolute']")
    transmissions = {t.find("joint").get("name"): t for t in root.findall("transmission")}
    for joint, angle in list(zip(arm, working, strict=True))[joints:]:
        root.remove(transmissions[joint.get("name")])
        _fix(joint, angle)
    last, transmission = arm[-1], transmissions[arm[-1].get("name")]
    for number in range(len(arm), joints):
        last, transmission = _repeat(root, last, transmission, f"joint_{number + 1}")
    tree.write(robot)
    angles = (*working, *[0.0] * (joints - len(arm)))[:joints]
    vehicle = replace(scenario.vehicle, robot=str(robot), working_rad=angles)
    return replace(scenario, vehicle=vehicle)


def _fix(joint: Element, angle: float) -> None:
    """Turns a revolute joint into a fixed one at an angle in rad."""
    axis = np.array(joint.find("axis").get("xyz").split(), dtype=float)
    joint.find("origin").set("rpy", " ".join(map(str, angle * axis)))
    joint.set("type", "fixed")
    for name in ("axis", "limit", "dynamics"):
        joint.remove(joint.find(name))


def _repeat(
    root: Element, last: Element, transmission: Element, name: str
) -> tuple[Element, Element]:
    """Inserts a light link and a joint before the last link; returns joint and transmission."""
    between = f"{name}_link"
    link = ElementTree.SubElement(root, "link", name=between)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value="0.005")
    moments = {"ixx": LIGHT, "iyy": LIGHT, "izz": LIGHT, "ixy": "0", "ixz": "0", "iyz": "0"}
    ElementTree.SubElement(inertial, "inertia", moments)
    joint, motor = copy.deepcopy(last), copy.deepcopy(transmission)
    joint.set("name", name)
    joint.find("parent").set("link", between)
    joint.find("origin").set("xyz", "0 0 0")
    axis = joint.find("axis")
    axis.set("xyz", "1 0 0" if axis.get("xyz") == "0 0 1" else "0 0 1")
    last.find("child").set("link", between)
    motor.find("joint").set("name", name)
    motor.find("actuator").set("name", f"{name}_motor")
    root.extend([joint, motor])
    return joint, motor

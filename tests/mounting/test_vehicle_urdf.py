"""URDF of a mounted arm, as text."""

from xml.dom.minidom import parseString

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from aerodrake.model.vehicle.robot import TOOL_AXIS
from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.link import ArmLink
from aerodrake.mounting.pose import Pose
from aerodrake.mounting.sizing import Given, Multirotor
from aerodrake.mounting.tool import Tool
from aerodrake.mounting.vehicle_urdf import VehicleDesign

MULTIROTOR = Multirotor.for_arm(1.0, 0.5, Given())
ARM = ArmTree("arm", (ArmLink("hand"),), ())


def design(direction) -> VehicleDesign:
    tool = Tool("hand", np.array([0.1, 0.2, 0.3]), np.array(direction), "")
    return VehicleDesign(ARM, tool, MULTIROTOR, Pose())


@given(st.floats(0, np.pi), st.floats(-np.pi, np.pi))
def test_the_tool_points_in_its_direction(inclination, azimuth):
    across = np.sin(inclination)
    direction = across * np.cos(azimuth), across * np.sin(azimuth), np.cos(inclination)
    robot = parseString(design(direction).urdf()).documentElement
    frames = {f.getAttribute("name"): f for f in robot.getElementsByTagName("frame")}
    rpy = [float(x) for x in frames["tool"].getAttribute("rpy").split()]
    assert RollPitchYaw(rpy).ToRotationMatrix() @ TOOL_AXIS == pytest.approx(direction, abs=1e-6)
    assert frames["tool"].getAttribute("xyz") == "0.1 0.2 0.3"


def test_notes_are_comments():
    text = design((0, 0, 1)).urdf(("scaled by --scale", "a > b"))
    assert text.splitlines()[1] == "<!-- scaled by - -scale -->"
    assert len(parseString(text).getElementsByTagName("frame")) == MULTIROTOR.rotors + 1

"""URDFs of arms as other programs export them, and their conversion."""

from pathlib import Path
from xml.dom.minidom import Element

from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.mounting.arm import Converted
from aerodrake.mounting.arm_urdf import read_arm
from aerodrake.mounting.convert import Conversion
from aerodrake.mounting.elements import arm_elements, element, filter_element

INERTIAL = """<inertial><origin xyz="0.01 0.02 {z}" rpy="0.1 0 0.3"/><mass value="{mass}"/>
<inertia ixx="2e-3" iyy="1.8e-3" izz="9e-4" ixy="1e-5" ixz="-2e-5" iyz="3e-5"/></inertial>"""
LIMIT = '<limit lower="-2" upper="2.5" effort="9" velocity="3"/>'


def link(name: str, mass: float = 0.5, inner: str = "") -> str:
    """Returns a link, without an inertial if its mass is zero."""
    inertial = INERTIAL.format(z=0.05, mass=mass) if mass else ""
    return f'<link name="{name}">{inertial}{inner}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inner: str = LIMIT) -> str:
    """Returns a joint 0.2 m along a tilted link, about an axis that is no unit vector."""
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="0.03 0 0.2" rpy="0.2 -0.4 0.6"/><axis xyz="0 2 1"/>{inner}</joint>"""


def robot(*parts: str) -> str:
    """Returns a URDF."""
    return f'<?xml version="1.0"?><robot name="arm">{"".join(parts)}</robot>'


FINGER_LIMIT = '<limit lower="0.01" upper="0.04" effort="5" velocity="1"/>'
MIMIC = '<mimic joint="left" multiplier="-2" offset="0.005"/>'
ARM = robot(
    link("world", 0),
    joint("to_world", "world", "base", "fixed", ""),
    link("base", 0.9),
    joint("turn", "base", "lower", "continuous", '<limit effort="7" velocity="2"/>'),
    link("lower"),
    joint("bend", "lower", "upper"),
    link("upper"),
    joint("wrist", "upper", "tool"),
    link("tool", 0.2),
    joint("left", "tool", "left_finger", "prismatic", FINGER_LIMIT),
    link("left_finger", 0.02),
    joint("right", "tool", "right_finger", "prismatic", FINGER_LIMIT + MIMIC),
    link("right_finger", 0.02),
    joint("other_joint", "base", "other", "revolute"),
    link("other", 0.3),
)
"""Arm of three joints below a link of the world, with a gripper and a branch."""


def read(text: str, folder: Path) -> Converted:
    """Reads the text of a URDF, in a file of a folder."""
    path = folder / "arm.urdf"
    path.write_text(text)
    return read_arm(path)


def vehicle(conversion: Conversion) -> Element:
    """Returns the URDF of a converted arm, joined to a base of 2 kg by the identity."""
    moments = dict.fromkeys(("ixx", "iyy", "izz"), "0.1") | dict.fromkeys(
        ("ixy", "ixz", "iyz"), "0"
    )
    mass = element("inertial", element("mass", value="2"), element("inertia", **moments))
    ends = element("parent", link="base"), element("child", link=conversion.arm.root)
    return element(
        "robot",
        element("link", mass, name="base"),
        element("joint", *ends, name="mount", type="fixed"),
        *arm_elements(conversion.arm, conversion.tool),
        element("frame", name="tool", link=conversion.tool),
        filter_element(["base", *(part.name for part in conversion.arm.links)]),
        name="vehicle",
    )


def plant(urdf: str) -> MultibodyPlant:
    """Returns the finalised plant of a URDF."""
    made = MultibodyPlant(0.0)
    Parser(made).AddModelsFromString(urdf, ".urdf")
    made.Finalize()
    return made


def pose(made: MultibodyPlant, root: str, tip: str, q: dict[str, float]) -> RigidTransform:
    """Returns the pose of a link in another, at positions of joints by name."""
    for name, position in q.items():
        made.GetJointByName(name).set_default_positions([position])
    context = made.CreateDefaultContext()
    return made.GetFrameByName(tip).CalcPose(context, made.GetFrameByName(root))

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


AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
ROD_INERTIAL = """<inertial><origin xyz="0 0 {centre}"/><mass value="{mass}"/>
<inertia ixx="{across}" iyy="{across}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial>"""
ROD_LIMIT = '<limit lower="-2.6" upper="2.6" effort="{effort}" velocity="3"/>'


def serial_arm(
    axes: str, length: float = 0.12, mass: float = 0.2, effort: float = 6.0, **options: object
) -> str:
    """Returns the URDF of an arm that points up at zero.

    Args:
        axes: One letter for each joint.
        length, mass: m and kg, of each link, a rod along z.
        effort: N m, of each joint.
        options: `kind` of the joints; `offset` in m of each joint along x; `end`, elements of
            links and joints after the last link, which is named as `link_N` with N joints.
    """
    kind, offset = options.get("kind", "revolute"), options.get("offset", 0.0)
    inertial = ROD_INERTIAL.format(
        centre=length / 2, mass=mass, across=mass * length**2 / 12, along=mass * 1e-4
    )
    shape = f'<origin xyz="0 0 {length / 2}"/><geometry><box size="0.03 0.03 {0.8 * length}"/>'
    body = f"{inertial}<collision>{shape}</geometry></collision>"
    parts = [f'<link name="link_{i}">{body}</link>' for i in range(len(axes) + 1)]
    for i, axis in enumerate(axes, start=1):
        parts.append(
            f'<joint name="joint_{i}" type="{kind}"><parent link="link_{i - 1}"/>'
            f'<child link="link_{i}"/><origin xyz="{offset} 0 {length}"/>'
            f'<axis xyz="{AXES[axis]}"/>{ROD_LIMIT.format(effort=effort)}</joint>'
        )
    return f'<robot name="arm">{"".join(parts)}{options.get("end", "")}</robot>'


def frame_link(name: str, parent: str, xyz: str = "0 0 0.12", joint: str = "fixed") -> str:
    """Returns a link without mass and the joint above it, which turns about z if it moves."""
    return f"""<link name="{name}"/><joint name="{name}_joint" type="{joint}">
    <parent link="{parent}"/><child link="{name}"/><origin xyz="{xyz}"/><axis xyz="0 0 1"/>
    {ROD_LIMIT.format(effort=1)}</joint>"""


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

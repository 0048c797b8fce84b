"""Conversion of an arm of any kind into a serial arm of revolute joints."""

from dataclasses import dataclass

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.chain import select_tree
from aerodrake.mounting.collision import box_links, check_meshes
from aerodrake.mounting.fixing import fix_joints
from aerodrake.mounting.hulls import estimate_masses
from aerodrake.mounting.inertias import correct_inertias
from aerodrake.mounting.limits import complete_limits
from aerodrake.mounting.names import rename, renamed_link
from aerodrake.mounting.scaling import scale
from aerodrake.support.errors import BadInput


@dataclass(frozen=True)
class Conversion:
    """Serial arm, ready to be joined to a base by a fixed joint at its root.

    Attributes:
        arm: The arm. All its joints are fixed, or revolute with all limits.
        tool: Name of the link of the tool.
        joints: Names of the revolute joints, from the root to the tool.
        changes: One sentence for each change of the URDF.
    """

    arm: ArmTree
    tool: str
    joints: tuple[str, ...]
    changes: tuple[str, ...]


def convert(
    read: Converted,
    tool: str,
    *,
    root: str = "",
    length: float = 1.0,
    mass: float = 1.0,
    source: object = "",
) -> Conversion:
    """Converts an arm that `read_arm` has read.

    Args:
        read: The arm and what has been changed already.
        tool: Name of the link of the tool, to which the chain of joints leads.
        root: Name of the link that is mounted; empty for the robot's own root.
        length, mass: Factors of all lengths and masses.
        source: The URDF, for messages.

    Raises:
        BadInput: if a link does not exist, a joint is of an unsupported type, a mesh is too large,
            or there are no masses or revolute joints.
    """
    arm, changes = read.arm, list(read.changes)
    steps = (
        lambda arm: select_tree(arm, tool, root),
        lambda arm: fix_joints(arm, tool),
        check_meshes,
        estimate_masses,
        correct_inertias,
        lambda arm: scale(arm, length, mass),
        lambda arm: complete_limits(arm, tool),
        box_links,
    )
    try:
        for step in steps:
            arm, more = step(arm)
            changes += more
    except BadInput as error:
        raise BadInput(error.source or source, *error.args[1:]) from None
    tool = renamed_link(arm, tool)
    arm, more = rename(arm)
    changes += more
    if any(joint.friction for joint in arm.moving(tool)):
        changes.append("joint friction is kept in the file, but Drake ignores it")
    names = tuple(joint.name for joint in arm.moving(tool))
    return Conversion(arm, tool, names, tuple(changes))

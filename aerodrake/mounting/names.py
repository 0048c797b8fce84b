"""Names of links and joints that clash with those of a vehicle, or that Drake cannot read."""

import re
from collections.abc import Iterable
from dataclasses import replace

from aerodrake.model.vehicle.robot import BASE_FRAME, PAYLOAD_BODY, TOOL_FRAME
from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.listed import listed

RESERVED = (BASE_FRAME, TOOL_FRAME, PAYLOAD_BODY, "world")
"""Names of links and frames of the vehicle, and of Drake's world."""
MOUNT = "mount"
"""Name of the fixed joint between base and arm."""
ROTOR = "rotor_"
"""Beginning of the names of rotors' frames; Drake names frames after joints, too."""
PREFIX = "arm_"
"""Prefix of renamed links and joints."""
UNREADABLE = re.compile(r"[^\w.-]+", re.ASCII)
"""Characters that separate names in Drake's scopes, or words in files."""
ENDS = re.compile(rf"^{UNREADABLE.pattern}|{UNREADABLE.pattern}$", re.ASCII)
"""Such characters at the beginning or end of a name."""
NAMELESS = "unnamed"
"""Name of a part without any other character."""


def rename(arm: ArmTree) -> Converted:
    """Renames links and joints whose names are reserved, or have other characters than a word."""
    links = _renamed((link.name for link in arm.links), is_link=True)
    joints = _renamed((joint.name for joint in arm.joints), is_link=False)
    new_links = tuple(replace(link, name=links.get(link.name, link.name)) for link in arm.links)
    new_joints = tuple(_joint(joint, links, joints) for joint in arm.joints)
    changes = [
        f"{noun} are renamed: {listed(f'{old} to {new}' for old, new in names.items())}"
        for noun, names in (("links", links), ("joints", joints))
        if names
    ]
    return Converted(replace(arm, links=new_links, joints=new_joints), tuple(changes))


def renamed_link(arm: ArmTree, name: str) -> str:
    """Returns the name that `rename` gives to a link of an arm."""
    return _renamed((link.name for link in arm.links), is_link=True).get(name, name)


def _joint(joint: ArmJoint, links: dict[str, str], joints: dict[str, str]) -> ArmJoint:
    return replace(
        joint,
        name=joints.get(joint.name, joint.name),
        parent=links.get(joint.parent, joint.parent),
        child=links.get(joint.child, joint.child),
    )


def _renamed(given: Iterable[str], is_link: bool) -> dict[str, str]:
    """Returns the new names of those that have to change."""
    names = list(given)
    taken, new = set(names), {}
    for name in names:
        word = UNREADABLE.sub("_", ENDS.sub("", name)) or NAMELESS
        if word in (RESERVED if is_link else (MOUNT,)) or word.startswith(ROTOR):
            word = PREFIX + word
        if word == name:
            continue
        unique, number = word, 2
        while unique in taken:
            unique, number = f"{word}_{number}", number + 1
        taken.add(unique)
        new[name] = unique
    return new

"""Uniform scaling of an arm's length and mass."""

from dataclasses import replace

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.link import ArmLink, Geometry, Inertial
from aerodrake.mounting.listed import shown
from aerodrake.mounting.pose import Pose


def scale(arm: ArmTree, length: float = 1.0, mass: float = 1.0) -> Converted:
    """Scales an arm.

    Inertias scale with mass * length^2. Torques scale with mass * length, as those of gravity do:
    effort, friction and damping. Limits of velocity and acceleration are unchanged.

    Args:
        arm: The arm.
        length: Factor of all lengths.
        mass: Factor of all masses.
    """
    if length == mass == 1:
        return Converted(arm)
    links = tuple(_link(link, length, mass) for link in arm.links)
    joints = tuple(_joint(joint, length, mass) for joint in arm.joints)
    sentence = (
        f"lengths are scaled by {shown(length)}, masses by {shown(mass)}, torques and damping by "
        f"{shown(mass * length)}, inertias by {shown(mass * length**2)}; velocities and "
        "accelerations are kept"
    )
    return Converted(replace(arm, links=links, joints=joints), (sentence,))


def _pose(pose: Pose, length: float) -> Pose:
    return pose._replace(xyz=tuple(length * x for x in pose.xyz))


def _link(link: ArmLink, length: float, mass: float) -> ArmLink:
    inertial = link.inertial
    if inertial is not None:
        moments = tuple(mass * length**2 * x for x in inertial.moments)
        inertial = Inertial(_pose(inertial.origin, length), mass * inertial.mass, moments)
    visuals, collisions = (
        tuple(_geometry(geometry, length) for geometry in geometries)
        for geometries in (link.visuals, link.collisions)
    )
    return ArmLink(link.name, inertial, visuals, collisions)


def _geometry(geometry: Geometry, length: float) -> Geometry:
    numbers = tuple(length * x for x in geometry.numbers)
    return replace(geometry, origin=_pose(geometry.origin, length), numbers=numbers)


def _joint(joint: ArmJoint, length: float, mass: float) -> ArmJoint:
    limits, motor = joint.limits, joint.motor
    if limits.effort is not None:
        limits = replace(limits, effort=mass * length * limits.effort)
    if motor is not None:
        motor = replace(motor, rotor_inertia=mass * length**2 * motor.rotor_inertia)
    return replace(
        joint,
        origin=_pose(joint.origin, length),
        limits=limits,
        damping=mass * length * joint.damping,
        friction=mass * length * joint.friction,
        motor=motor,
    )

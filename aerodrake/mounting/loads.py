"""Largest loads of an arm's joints over its configurations."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.inertias import inertia_matrix
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.spread import spread

SAMPLES = 32
"""Number of configurations, spread over the joints' range."""


class Load(NamedTuple):
    """Largest load of a joint.

    Attributes:
        torque: N m, that holds the links below it against gravity in any direction.
        inertia: kg m^2, of the links below it about its axis, and of its motor.
    """

    torque: float
    inertia: float


def joint_loads(arm: ArmTree, joints: list[ArmJoint]) -> dict[str, Load]:
    """Returns the largest loads of an arm's joints, whose limits are complete, by name."""
    lower = np.array([joint.limits.lower for joint in joints])
    upper = np.array([joint.limits.upper for joint in joints])
    shares = spread(SAMPLES, len(joints))
    loads = [_loads(arm, joints, lower + (upper - lower) * share) for share in shares]
    return {
        joint.name: Load(*np.max([load[i] for load in loads], axis=0).tolist())
        for i, joint in enumerate(joints)
    }


def _loads(arm: ArmTree, joints: list[ArmJoint], q: np.ndarray) -> np.ndarray:
    """Returns torques and inertias (n, 2) of the joints at q (n,) rad."""
    names = [joint.name for joint in joints]
    poses = arm.poses(dict(zip(names, q.tolist(), strict=True)))
    bodies = [(link.name, link.inertial) for link in arm.links if link.inertial is not None]
    masses, centres, inertias = {}, {}, {}
    for name, inertial in bodies:
        X = poses[name] @ inertial.origin.transform()
        R = X.rotation().matrix()
        masses[name], centres[name] = inertial.mass, X.translation()
        inertias[name] = R @ inertia_matrix(inertial.moments) @ R.T
    loads = []
    for joint in joints:
        X = poses[joint.child]
        axis = X.rotation() @ (np.array(joint.axis) / np.linalg.norm(joint.axis))
        below = [name for name in arm.below(joint.child) if name in masses]
        arms = {name: np.cross(axis, centres[name] - X.translation()) for name in below}
        moment = sum((masses[name] * arms[name] for name in below), np.zeros(3))
        motor = joint.motor
        inertia = motor.gear_ratio**2 * motor.rotor_inertia if motor else 0.0
        for name in below:
            inertia += axis @ inertias[name] @ axis + masses[name] * arms[name] @ arms[name]
        loads.append((GRAVITY * np.linalg.norm(moment), inertia))
    return np.array(loads)

"""Joint of an arm: its links, limits and motor."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RotationMatrix

from aerodrake.mounting.pose import Pose

MOVING = ("revolute", "continuous")
"""Types of the joints that can be part of an arm."""


@dataclass(frozen=True)
class Limits:
    """Limits of a joint; None for those that are not given.

    Attributes:
        lower, upper: rad, or m of a prismatic joint.
        effort: N m.
        velocity: rad/s.
        acceleration: rad/s^2.
    """

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True)
class Mimic:
    """Relation of a joint's position to another's: multiplier * position + offset.

    Attributes:
        joint: Name of the other joint.
        multiplier: Ratio of the positions.
        offset: rad, or m of a prismatic joint.
    """

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Motor:
    """Motor behind a gear.

    Attributes:
        gear_ratio: Ratio of the motor's rate to the joint's.
        rotor_inertia: kg m^2, before the gear.
    """

    gear_ratio: float = 1.0
    rotor_inertia: float = 0.0


@dataclass(frozen=True)
class ArmJoint:
    """Joint of an arm.

    Attributes:
        name: Its name.
        kind: Its type in the URDF.
        parent, child: Names of its links.
        origin: Pose of the child's frame in the parent's at zero.
        axis: Axis in the child's frame.
        limits: Its limits.
        damping: N m s/rad.
        friction: N m.
        mimic: The joint that it follows.
        motor: Its motor; None for one without inertia.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose = Pose()
    axis: tuple[float, ...] = (1.0, 0.0, 0.0)
    limits: Limits = Limits()
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None
    motor: Motor | None = None

    @property
    def is_moving(self) -> bool:
        """True for a revolute joint."""
        return self.kind in MOVING

    def at(self, position: float) -> Self:
        """Returns the joint fixed at a position in rad, or m of a prismatic joint."""
        origin = self.origin
        if position:
            axis = np.array(self.axis) / math.hypot(*self.axis)
            moved = RigidTransform(position * axis)
            if self.is_moving:
                moved = RigidTransform(RotationMatrix(AngleAxis(position, axis)))
            origin = Pose.of(self.origin.transform() @ moved)
        return type(self)(self.name, "fixed", self.parent, self.child, origin)

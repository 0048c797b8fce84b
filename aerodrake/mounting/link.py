"""Link of an arm: its mass and geometry."""

from dataclasses import dataclass
from pathlib import Path

from aerodrake.mounting.pose import Pose


@dataclass(frozen=True)
class Inertial:
    """Mass of a link.

    Attributes:
        origin: Centre of mass and axes of the inertia, in the link's frame.
        mass: kg.
        moments: kg m^2, ixx, iyy, izz, ixy, ixz, iyz about the centre of mass.
    """

    origin: Pose
    mass: float
    moments: tuple[float, ...]


@dataclass(frozen=True)
class Geometry:
    """Visual or collision geometry of a link.

    Attributes:
        origin: Its pose in the link's frame.
        shape: Name of the shape in a URDF, a key of `shapes.ATTRIBUTES`.
        numbers: Numbers of the shape's attributes in order, m; scale factors of a mesh.
        file: File of a mesh.
        rgba: Colour; None for the mesh's own.
    """

    origin: Pose
    shape: str
    numbers: tuple[float, ...]
    file: Path | None = None
    rgba: tuple[float, ...] | None = None


@dataclass(frozen=True)
class ArmLink:
    """Link of an arm."""

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Geometry, ...] = ()
    collisions: tuple[Geometry, ...] = ()

    @property
    def mass(self) -> float:
        """kg; zero without an `<inertial>`."""
        return self.inertial.mass if self.inertial else 0.0

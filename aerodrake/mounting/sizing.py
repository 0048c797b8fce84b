"""Sizes of a multirotor for an arm: masses, rotors and legs, in proportion to the packaged one."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.scenario import Rotor

BASE_PER_ARM = 2.2
"""Mass of the base over that of the arm; 2.6 kg and 1.2 kg in the packaged vehicle."""
MOST_KG = {4: 8.0, 6: 25.0, 8: math.inf}
"""Mass of the whole vehicle up to which each number of rotors carries it."""
HOVER_SHARE = 0.47
"""Thrust in hover over the largest thrust, as in the packaged vehicle."""
GYRATION = 0.42, 0.57
"""Radii of gyration of the base about a horizontal axis and its vertical one, over the radius of
the rotors' circle, as in the packaged vehicle."""
PACKAGED_DISC_M = 0.216
"""Radius of a rotor of the packaged vehicle, whose other sizes are the defaults of `Rotor`."""
PACKAGED_KG, PACKAGED_FEET_M = 2.6, 0.38
"""Mass of the packaged vehicle's base, and depth of its feet."""
GAP = 1.2
"""Distance between neighbouring rotors over the diameter of their discs."""
RADIUS_PER_REACH = 0.5
"""Smallest radius of the rotors' circle over the arm's reach."""
MOST_INERTIA = 2.0
"""Largest moment of inertia of the arm about a horizontal axis through the base's origin, over the
base's. Above the bandwidth of the joints the arm does not turn with the base, and the gain of the
attitude's loop grows by up to one plus this ratio."""


@dataclass(frozen=True)
class Multirotor:
    """A multirotor whose rotors are evenly spaced on a circle.

    Attributes:
        mass: kg, of the base, which is all but the arm.
        rotors: Number of rotors.
        radius: m, of the rotors' circle.
        disc: m, radius of a rotor's disc.
        max_thrust: N, largest thrust of a rotor.
        torque_ratio: m, torque over thrust of a rotor.
        lag: s, time constants of a rotor's rise and fall.
        feet: m, depth of the feet below the base's origin.
    """

    mass: float
    rotors: int
    radius: float
    disc: float
    max_thrust: float
    torque_ratio: float
    lag: tuple[float, float]
    feet: float

    @property
    def inertia(self) -> np.ndarray:
        """(3,) kg m^2, moments about the base's axes."""
        level, upright = (self.mass * (share * self.radius) ** 2 for share in GYRATION)
        return np.array([level, level, upright])

    @property
    def scale(self) -> float:
        """Size of the body over that of the packaged vehicle, at equal density."""
        return (self.mass / PACKAGED_KG) ** (1 / 3)

    @property
    def angles(self) -> np.ndarray:
        """(rotors,) rad, directions of the rotors from the base's x axis, half a gap beside it."""
        return 2 * np.pi / self.rotors * (np.arange(self.rotors) + 0.5)

    @property
    def rotor_height(self) -> float:
        """m, height of the rotors above the base's origin."""
        return 0.05 * self.scale

    @classmethod
    def for_arm(cls, mass: float, reach: float, given: "Given", inertia: float = 0.0) -> Self:
        """Sizes a multirotor for an arm.

        Rotors are geometrically similar with equal tip speed: radius, torque over thrust and lag
        grow with the cube root of the thrust. Smaller rotors get the packaged vehicle's lag. A
        base whose moment of inertia is too small for the arm's grows, geometrically similar unless
        some of its sizes are given.

        Args:
            mass: kg, of the arm.
            reach: m, length of the arm from its first joint to the tool.
            given: Sizes that are not to be chosen.
            inertia: kg m^2, largest moment of the arm about a horizontal axis through the base's
                origin.
        """
        base = given.base_mass or two_digits(BASE_PER_ARM * mass)
        sized = cls._carrying(mass, base, RADIUS_PER_REACH * reach, given)
        lack = inertia / (MOST_INERTIA * sized.inertia[0])
        if lack <= 1:
            return sized
        heavier, wider = given.growth
        if heavier:
            base = two_digits(base * lack**heavier)
        return cls._carrying(mass, base, sized.radius * lack**wider, given)

    @classmethod
    def _carrying(cls, mass: float, base: float, least_radius: float, given: "Given") -> Self:
        """Returns a multirotor of a mass for an arm of a mass, with rotors that carry both."""
        total = mass + base
        rotors = given.rotors or min(n for n, most in MOST_KG.items() if total <= most)
        thrust = given.max_thrust or two_digits(total * GRAVITY / HOVER_SHARE / rotors)
        size = (thrust / Rotor.max_thrust_n) ** (1 / 3)  # Geometrically similar rotors.
        slower = max(size, 1.0)
        disc = PACKAGED_DISC_M * size
        least = max(GAP * disc / math.sin(math.pi / rotors), least_radius)
        return cls(
            mass=base,
            rotors=rotors,
            radius=given.radius or two_digits(least),
            disc=disc,
            max_thrust=thrust,
            torque_ratio=round(Rotor.torque_ratio_m * size, 4),
            lag=(round(Rotor.lag_up_s * slower, 4), round(Rotor.lag_down_s * slower, 4)),
            feet=PACKAGED_FEET_M * (base / PACKAGED_KG) ** (1 / 3),
        )


@dataclass(frozen=True)
class Given:
    """Sizes of a multirotor that are not to be chosen; None for those that are.

    Attributes:
        base_mass: kg.
        rotors: Their number, even.
        radius: m, of the rotors' circle.
        max_thrust: N, of each.
    """

    base_mass: float | None = None
    rotors: int | None = None
    radius: float | None = None
    max_thrust: float | None = None

    @property
    def growth(self) -> tuple[float, float]:
        """Exponents of the base's inertia in the mass and radius of a base that grows with it.

        Given rotors carry a given mass. Similar bodies have inertias with the fifth power of
        their size.
        """
        has_mass, has_radius = bool(self.base_mass or self.max_thrust), bool(self.radius)
        if has_mass:
            return (0.0, 0.0) if has_radius else (0.0, 0.5)
        return (1.0, 0.0) if has_radius else (0.6, 0.2)


def two_digits(value: float) -> float:
    """Returns a positive number rounded up to two significant digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return round(math.ceil(value / unit - 1e-9) * unit, 9)

"""Request for a vehicle: an arm, and the choices that are given."""

import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from aerodrake.mounting.names import UNREADABLE
from aerodrake.mounting.sizing import Given
from aerodrake.support.errors import BadInput
from aerodrake.support.limits import BASE_KG, POSE, ROTOR_RADIUS_M, ROTORS, SCALE, THRUST_N

PLACE, TURNED = 3, 6
"""Count of numbers of a position, and of a position with roll, pitch and yaw."""


@dataclass(frozen=True)
class Request:
    """Arm to be mounted, and given choices; arguments are named as in `aerodrake.mount`.

    Attributes:
        urdf: Path of the arm's URDF.
        tool: Link of the tool; empty to guess it.
        root: Link that is mounted on the base; empty for the arm's first one.
        scale: Factor of all lengths of the arm, and of its masses; of the masses the cube of the
            first without a second one.
        mount: m and rad, position, or position, roll, pitch and yaw, of the arm's first link in
            the base's frame; empty to choose them.
        packages: Folders of ROS packages, or that contain them.
        given: Sizes of the multirotor.

    Raises:
        BadInput: if a number is out of its range.
    """

    urdf: Path
    tool: str = ""
    root: str = ""
    scale: tuple[float, ...] = (1.0,)
    mount: tuple[float, ...] = ()
    packages: tuple[Path, ...] = ()
    given: Given = Given()

    def __post_init__(self) -> None:
        """Checks the numbers."""
        for name, problem in self._problems():
            raise BadInput(name, "", problem)

    def _problems(self) -> Iterator[tuple[str, str]]:
        if len(self.scale) not in (1, 2) or not all(SCALE[0] <= x <= SCALE[1] for x in self.scale):
            low, high = SCALE
            expected = "expected a factor of lengths, or factors of lengths and masses, each in "
            yield "scale", f"{expected}[{low:g}, {high:g}], got {_shown(self.scale)}"
        low, high = POSE
        if len(self.mount) not in (0, PLACE, TURNED) or not all(
            low <= x <= high for x in self.mount
        ):
            expected = "expected x, y, z in m, or x, y, z in m and roll, pitch, yaw in rad, each in"
            yield "mount", f"{expected} [{low:g}, {high:g}], got {_shown(self.mount)}"
        for name, value, (low, high), unit in (
            ("base_mass", self.given.base_mass, BASE_KG, "kg"),
            ("rotors", self.given.rotors, ROTORS, "rotors"),
            ("rotor_radius", self.given.radius, ROTOR_RADIUS_M, "m"),
            ("max_thrust", self.given.max_thrust, THRUST_N, "N"),
        ):
            if value is not None and not low <= value <= high:
                yield name, f"expected a number in [{low:g}, {high:g}] {unit}, got {value:g}"
        if (self.given.rotors or 0) % 2:
            yield "rotors", f"expected an even number, got {self.given.rotors}"

    @property
    def length(self) -> float:
        """Factor of all lengths."""
        return self.scale[0]

    @property
    def mass(self) -> float:
        """Factor of all masses."""
        return self.scale[1] if len(self.scale) > 1 else self.scale[0] ** 3

    @property
    def name(self) -> str:
        """Name of the vehicle: that of the file, as a plain word."""
        return UNREADABLE.sub("_", self.urdf.stem).strip(".") or "arm"

    @property
    def command(self) -> str:
        """Command line with the same choices, without the folders above the arm's file."""
        given = self.given
        numbers = {
            "--scale": self.scale if self.scale != (1.0,) else (),
            "--mount": self.mount,
            "--base-mass": (given.base_mass,),
            "--rotors": (given.rotors,),
            "--rotor-radius": (given.radius,),
            "--max-thrust": (given.max_thrust,),
        }
        options = {
            "--tool": [self.tool],
            "--root": [self.root],
            **{name: [f"{x:.10g}" for x in xs if x is not None] for name, xs in numbers.items()},
        }
        words = [self.urdf.name]
        for name, values in options.items():
            words += [name, *values] if any(values) else []
        for path in self.packages:
            words += ["--package-path", str(path)]
        return shlex.join(["aerodrake", "mount", *words])


def _shown(numbers: tuple[float, ...]) -> str:
    return " ".join(f"{number:g}" for number in numbers)

"""Reference sections of a scenario: the end-effector's path and the tool's direction."""

from dataclasses import dataclass

from aerodrake.scenario.schema import Kind, file, quantity

SHORTEST_AXIS = 1e-3
"""Length below which a vector has no direction."""


@dataclass(frozen=True)
class Hover(Kind, kind="hover"):
    """The end-effector's initial position."""


@dataclass(frozen=True)
class Clover(Kind, kind="clover"):
    """Four-leaf clover r = a cos(2 theta) in the horizontal plane, starting at a petal's tip."""

    amplitude_m: float = quantity(0.5, "m", 0.01, 10.0)
    lap_s: float = quantity(24.0, "s", 1.0, 1000.0)
    # Smooth start: time in which the angular rate rises from 0 to 2 pi / lap_s.
    start_s: float = quantity(3.0, "s", 0.1, 100.0)


@dataclass(frozen=True)
class FigureEight(Kind, kind="figure_eight"):
    """A Gerono lemniscate, `length_m` long and `width_m` wide, in a tilted plane."""

    length_m: float = quantity(0.6, "m", 0.01, 10.0)
    width_m: float = quantity(0.3, "m", 0.01, 10.0)
    tilt_rad: float = quantity(0.0, "rad", -1.5708, 1.5708)
    lap_s: float = quantity(12.0, "s", 1.0, 1000.0)
    start_s: float = quantity(3.0, "s", 0.1, 100.0)


@dataclass(frozen=True)
class Lissajous(Kind, kind="lissajous"):
    """Lissajous curve A_i [sin(2 pi t / T_i + phi_i) - sin(phi_i)] on each world axis i."""

    amplitude_m: tuple[float, ...] = quantity((0.4, 0.3, 0.15), "m", 0.0, 10.0, length=3)
    period_s: tuple[float, ...] = quantity((16.0, 8.0, 16.0), "s", 1.0, 1000.0, length=3)
    phase_rad: tuple[float, ...] = quantity((0.0, 0.0, 1.5708), "rad", -6.2832, 6.2832, length=3)
    start_s: float = quantity(3.0, "s", 0.1, 100.0)


@dataclass(frozen=True)
class MovingTarget(Kind, kind="moving_target"):
    """A point at a constant height above a target that moves in a straight line."""

    target_m: tuple[float, ...] = quantity((0.0, 1.4, 0.0), "m", -100.0, 100.0, length=3)
    velocity_m_s: tuple[float, ...] = quantity((0.0, 0.05, 0.0), "m/s", -2.0, 2.0, length=3)
    height_m: float = quantity(0.6, "m", 0.0, 10.0)


@dataclass(frozen=True)
class Waypoints(Kind, kind="waypoints"):
    """Smooth interpolation of a CSV with the header `t,x,y,z` (s and m, world frame)."""

    file: str = file()
    # Step to whose multiples the file's coordinates are rounded: points are not interpolated but
    # smoothed, with the mean squared deviation of rounding. 0: interpolated.
    rounding_m: float = quantity(0.0, "m", 0.0, 0.1)


@dataclass(frozen=True)
class OrientationOff(Kind, kind="off"):
    """No orientation task: the position task alone determines the tool's direction."""


@dataclass(frozen=True)
class FixedAxis(Kind, kind="fixed"):
    """A constant direction of the tool's axis in the world frame, of any length."""

    axis: tuple[float, ...] = quantity((0.0, 0.0, -1.0), "1", -1000.0, 1000.0, length=3)


@dataclass(frozen=True)
class AxisAlong(Kind, kind="along"):
    """Smooth interpolation of directions of the tool's axis, from a CSV with header `t,ax,ay,az`.

    Times are in s, directions are vectors of any length in the world frame.
    """

    file: str = file()


Reference = Hover | Clover | FigureEight | Lissajous | MovingTarget | Waypoints
Orientation = OrientationOff | FixedAxis | AxisAlong

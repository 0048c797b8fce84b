"""Panels of the figures of an analysis."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.mode_shape import ModeShape
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.reports.figures import (
    AXIS_COLORS,
    EDGE,
    INK,
    REFERENCE,
    legend_above,
    plain_ticks,
)

UNSTABLE = AXIS_COLORS[0]
STABLE = AXIS_COLORS[2]

DAMPING_RATIOS = (0.0, 0.1, 0.3, 0.6)
"""Damping ratios with a line in the map of eigenvalues."""

FREQUENCIES = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
"""Fractions of the Nyquist frequency with a line in the map of eigenvalues."""

FREQUENCY_TICKS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Hz, labels of the frequency axis; it is linear up to the first above 0."""

FASTEST_DECAY_1_S = 40.0
"""Decay rate from which on modes are left out of the map of growth and frequency."""

LABEL_ROOM = 0.15
"""Fraction of the width of the map of growth that is left free for names at the right."""

LEAST_DISTANCE = 0.06
"""Distance of eigenvalues in the z plane below which only the first has its number."""

LEAST_MOTION = 0.03
"""Fraction of the largest motion of a mode below which a motion is not drawn."""

CURVE_COLORS = (*AXIS_COLORS, "#e8590c", "#5f3dc4", "#0c8599", "#862e9c", "#495057")


def draw_eigenvalues(axes: Axes, point: OperatingPoint, numbered: Sequence[Eigenmode]) -> None:
    """Draws the upper half of the z plane: all eigenvalues, with the numbers of some modes.

    Dotted lines are those of constant damping ratio and of constant natural frequency.
    """
    _draw_grid(axes, point.system.dt)
    for mode in point.modes:
        color = STABLE if mode.is_stable else UNSTABLE
        z = mode.eigenvalue
        axes.plot(z.real, abs(z.imag), "x", color=color, markersize=4, markeredgewidth=0.9)
    labelled: list[complex] = []
    for number, mode in enumerate(numbered, start=1):
        z = complex(mode.eigenvalue.real, abs(mode.eigenvalue.imag))
        if any(abs(z - other) < LEAST_DISTANCE for other in labelled):
            continue
        labelled.append(z)
        outward = 9 * z / abs(z)
        axes.annotate(
            str(number),
            (z.real, z.imag),
            (outward.real, outward.imag),
            textcoords="offset points",
            color=INK if mode.is_stable else UNSTABLE,
            fontsize=8,
            ha="center",
            va="center",
        )
    most = max([1.0, *(abs(mode.eigenvalue) for mode in point.modes)])
    axes.set(xlim=(-1.16 * most, 1.16 * most), ylim=(-0.06, 1.18 * most))
    axes.set(xlabel="Re z", ylabel="Im z")
    axes.set_aspect("equal", adjustable="box")
    axes.grid(False)


def _draw_grid(axes: Axes, dt: float) -> None:
    """Draws the lines of `DAMPING_RATIOS` and `FREQUENCIES`, with their frequencies."""
    thin = {"color": EDGE, "linewidth": 0.6, "zorder": 1}
    for damping in DAMPING_RATIOS:
        angle = np.linspace(0.0, np.pi, 181)
        z = np.exp(angle * (1j - damping / np.sqrt(1 - damping**2)))
        axes.plot(z.real, z.imag, **thin if damping else {**thin, "color": INK})
    for fraction in FREQUENCIES:
        damping = np.linspace(0.0, 1.0, 61)
        natural = np.pi * fraction
        z = np.exp(natural * (-damping + 1j * np.sqrt(1 - damping**2)))
        axes.plot(z.real, z.imag, **thin)
        end = 1.07 * np.exp(1j * natural)
        hertz = f"{fraction / (2 * dt):g}" + (" Hz" if fraction == 1.0 else "")
        side = {"ha": "center", "va": "center", "fontsize": 7, "color": EDGE}
        axes.text(end.real, end.imag + (0.04 if fraction == 1.0 else 0.0), hertz, **side)


def draw_growth(axes: Axes, point: OperatingPoint, named: Sequence[Eigenmode]) -> None:
    """Draws growth and frequency of the modes, with the numbers and first motions of some."""
    shown = [mode for mode in point.modes if mode.growth_1_s > -FASTEST_DECAY_1_S]
    for mode in shown:
        color = STABLE if mode.is_stable else UNSTABLE
        axes.plot(mode.growth_1_s, mode.frequency_hz, "x", color=color, markersize=5)
    axes.axvline(0.0, **REFERENCE)
    axes.set_yscale("symlog", linthresh=FREQUENCY_TICKS[1], linscale=0.5)
    nyquist = 0.5 / point.system.dt
    highest = max([nyquist, *(mode.frequency_hz for mode in shown)])
    ticks = [*(tick for tick in FREQUENCY_TICKS if tick < nyquist), nyquist]
    ticks += [highest] if highest > 1.5 * nyquist else []
    axes.set_yticks(ticks, [f"{tick:.3g}" for tick in ticks])
    axes.set_yticks([], minor=True)
    axes.set_ylim(-0.1, 1.1 * highest)
    axes.set(xlabel="growth / 1/s", ylabel="frequency / Hz")
    low, high = axes.get_xlim()
    axes.set_xlim(low, high + LABEL_ROOM * (high - low))
    heights: list[float] = []
    numbers = {id(mode): number for number, mode in enumerate(named, start=1)}
    for mode in sorted(named, key=lambda mode: mode.frequency_hz):
        motions = point.motions(mode) or mode.participants
        place = mode.growth_1_s, mode.frequency_hz
        height = axes.transData.transform(place)[1] * 72 / axes.figure.dpi
        heights.append(max([height, *(other + 9 for other in heights[-1:])]))
        axes.annotate(
            f"{numbers[id(mode)]} {motions[0].name if motions else ''}",
            place,
            (5, heights[-1] - height + 3),
            textcoords="offset points",
            fontsize=7.5,
            color=INK if mode.is_stable else UNSTABLE,
            parse_math=False,
        )


def draw_shape(row: Sequence[Axes], shape: ModeShape) -> None:
    """Draws the motions of a mode over one period, for a tool that moves by 1 mm.

    Args:
        row: Axes of the lengths and of the angles.
        shape: The mode's shape.
    """
    phase = np.linspace(0.0, 2 * np.pi, 121)
    groups = (
        ("mm", 1.0, shape.lengths),
        ("deg", np.degrees(1e-3), shape.angles),
    )
    for axes, (unit, factor, amplitudes) in zip(row, groups, strict=True):
        for (name, amplitude), color in zip(_large(amplitudes).items(), CURVE_COLORS, strict=False):
            motion = factor * np.real(amplitude * np.exp(1j * phase))
            style = "--" if name in shape.lengths and not name.startswith("tool") else "-"
            axes.plot(np.degrees(phase), motion, style, color=color, label=name)
        axes.set(ylabel=unit, xlim=(0, 360), xticks=range(0, 361, 90))
        if axes.lines:
            legend_above(axes, 6)


def _large(amplitudes: Mapping[str, complex]) -> dict[str, complex]:
    """Returns the largest amplitudes, as many as there are colours, in their own order."""
    sizes = sorted((abs(value) for value in amplitudes.values()), reverse=True)
    least = max(LEAST_MOTION * sizes[0], sizes[min(len(sizes), len(CURVE_COLORS)) - 1])
    return {name: value for name, value in amplitudes.items() if abs(value) >= max(least, 1e-300)}


def draw_steps(axes: Axes, responses: Sequence[StepResponse]) -> None:
    """Draws the distance of the tool after a step of each disturbance, in mm."""
    for response, color in zip(responses, CURVE_COLORS, strict=False):
        distance = 1e3 * np.linalg.norm(response.values, axis=1)
        axes.plot(response.time_s, distance, color=color, label=response.input.replace("_", " "))
    if responses:
        axes.set_xlim(0, responses[0].time_s[-1])
        axes.set_ylabel(f"tool / m{responses[0].unit}")
        legend_above(axes, 3)
    axes.set_ylim(bottom=0)


def draw_gains(axes: Axes, responses: Sequence[FrequencyResponse]) -> None:
    """Draws the gain from each input to the tool over the frequency."""
    for response, color in zip(responses, CURVE_COLORS, strict=False):
        label = f"{response.input.replace('_', ' ')}, m{response.unit}"
        axes.plot(response.hz, 1e3 * response.magnitude, color=color, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_ticks(axes.xaxis)
    axes.margins(x=0)
    axes.set_ylabel("gain to the tool")
    if responses:
        legend_above(axes, 2)


def draw_path(row: Sequence[Axes], analysis: Analysis) -> None:
    """Draws damping ratio and frequency of the least damped mode along the path.

    Args:
        row: Axes of the damping ratio and of the frequency.
        analysis: An analysis with a path.
    """
    points = [point for point in analysis.path if point.least_damped]
    times = [point.time_s for point in points]
    for axes, attribute in zip(row, ("damping", "frequency_hz"), strict=True):
        values = [getattr(point.least_damped[0], attribute) for point in points]
        colors = [STABLE if point.is_stable else UNSTABLE for point in points]
        axes.plot(times, values, color=EDGE)
        axes.scatter(times, values, c=colors, s=14, zorder=3)
    row[0].axhline(0.0, **REFERENCE)
    row[0].set_ylabel("damping ratio")
    row[1].set_ylabel("frequency / Hz")
    row[-1].set_xlabel("reference time / s")

"""Figure of a benchmark: tick times by solver, horizon and joints, and the parts of the loop."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from aerodrake.bench.report import Figures, medians
from aerodrake.bench.scaling import FITTED_FROM, PEER
from aerodrake.reports.figures import ACCENT, EDGE, INK, REFERENCE, STYLE, plain_ticks, write_png

OWN = "aerodrake"
"""The MPC's solver with its defaults."""

OWN_DOT = {"color": ACCENT, "marker": "o", "markerfacecolor": ACCENT}
VARIANT_DOT = {"color": ACCENT, "marker": "o", "markerfacecolor": "white"}
PEER_DOT = {"color": INK, "marker": "s", "markerfacecolor": "white"}
"""Dots of the MPC's solver, of its variants, and of the other solvers, different in grey too."""

FORMING = {"color": "#4dabf7", "marker": "^", "linestyle": (0, (5, 1.5))}

PARTS = {
    "mpc_forming_and_solving": "mpc: forming and solving",
    "mpc_overhead": "mpc: ports and state",
}
"""Labels of parts of systems."""


def plot_bench(figures: Figures, path: Path) -> None:
    """Writes the figure as PNG.

    Args:
        figures: Result of `bench`.
        path: Path of the file.

    Raises:
        BadInput: if the file cannot be written.
    """
    with rc_context(STYLE | {"axes.titlesize": 11, "axes.titlelocation": "left", "font.size": 10}):
        write_png(bench_figure(figures), path)


def bench_figure(figures: Figures) -> Figure:
    """Returns the figure of a benchmark's results, with values and units beside its marks."""
    figure = Figure(figsize=(12, 14), dpi=110, layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1.1, 1, 1.4))
    solvers, tick = _solvers(figures), figures["tick"]
    constrained = {name: solver["bounded"] for name, solver in solvers.items()}
    title = f"MPC tick, forming and solving: {tick['ticks']:,} recorded ticks"
    _draw_times(figure.add_subplot(grid[0, 0]), solvers, title)
    title = f"{tick['bounded']['ticks']:,} ticks with an active constraint"
    _draw_times(figure.add_subplot(grid[0, 1]), constrained, title)
    _draw_horizon(figure.add_subplot(grid[1, 0]), figures["scaling"])
    _draw_joints(figure.add_subplot(grid[1, 1]), figures["scaling"])
    _draw_parts(figure.add_subplot(grid[2, :]), figures)
    return figure


def _solvers(figures: Figures) -> dict[str, Figures]:
    """Returns the results of all solvers: the MPC's, its variants, and the installed peers."""
    variants = {f"{OWN} {name}": solver for name, solver in figures["solvers"].items()}
    peers = {
        f"{name} {peer['version']}": peer
        for name, peer in figures["peers"].items()
        if peer["version"] is not None
    }
    return {OWN: figures["tick"], **variants, **peers}


def _draw_times(axes: Axes, solvers: Mapping[str, Figures], title: str) -> None:
    """Draws median and p99 of the solvers that have any, the fastest at the top."""
    times = {
        name: (solver["median_ms"], solver["p99_ms"])
        for name, solver in solvers.items()
        if solver["median_ms"] is not None
    }
    names = sorted(times, key=times.__getitem__)
    for place, name in enumerate(names):
        median, p99 = times[name]
        dot = VARIANT_DOT if name.startswith(OWN) else PEER_DOT
        dot = OWN_DOT if name == OWN else dot
        axes.plot([median, p99], [place, place], color=dot["color"], linewidth=2)
        axes.plot(p99, place, color=dot["color"], marker="|", markersize=11, markeredgewidth=2)
        axes.plot(median, place, **dot, markersize=7)
        axes.annotate(f"   {median:.2f}, {p99:.2f} ms", (p99, place), va="center", fontsize=9)
    axes.set_yticks(range(len(names)), names)
    for label in axes.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() == OWN else "normal")
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xscale("log")
    if times:
        low, high = 0.7 * min(times.values())[0], max(p99 for _, p99 in times.values())
        axes.set_xlim(low, high * max(4, (high / low) ** 0.6))  # Space for the values.
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        plain_ticks(axes.xaxis)
    axes.set_title(title)
    axes.set_xlabel("median (dot) and 99th percentile (bar) / ms")


def _draw_horizon(axes: Axes, scaling: Figures) -> None:
    rows = scaling["horizon"]
    N = np.array([row["N"] for row in rows])
    times = medians(rows)
    lines = {
        OWN: (times["median"], OWN_DOT),
        "its forming": ([row["forming_median_ms"] for row in rows], FORMING),
    }
    if PEER in times:
        lines[PEER] = (times[PEER], PEER_DOT)
    axes.set_xscale("log")
    axes.set_yscale("log")
    _draw_lines(axes, N, lines)
    fitted = N >= FITTED_FROM
    start = np.array(times["median"])[fitted][0]
    axes.plot(N[fitted], start * (N[fitted] / N[fitted][0]) ** 2, **REFERENCE)
    axes.set_xticks(N, list(map(str, N)), minor=False)
    axes.minorticks_off()
    plain_ticks(axes.yaxis)
    exponent = f"N^{scaling['horizon_exponent']:.2f} from N = {FITTED_FROM} on (dashed: N^2)"
    axes.set_title(f"Median tick by horizon: {exponent}", parse_math=False)
    axes.set(xlabel="stages N of the horizon", ylabel="forming and solving / ms")


def _draw_joints(axes: Axes, scaling: Figures) -> None:
    n = np.array([row["joints"] for row in scaling["joints"]])
    times = medians(scaling["joints"])
    lines = {OWN: (times["median"], OWN_DOT)}
    if PEER in times:
        lines[PEER] = (times[PEER], PEER_DOT)
    _draw_lines(axes, n, lines)
    axes.set_title("Median tick by joints")
    axes.set(xlabel="joints of the arm", ylabel="forming and solving / ms", xticks=n)
    axes.set_ylim(0, 1.1 * max(max(values) for values, _ in lines.values()))


def _draw_lines(
    axes: Axes, x: np.ndarray, lines: Mapping[str, tuple[Sequence[float], Figures]]
) -> None:
    """Draws lines with their names and last values at their ends."""
    for name, (times, style) in lines.items():
        axes.plot(x, times, **style)
        text = f"  {name}\n  {times[-1]:.2f} ms"
        axes.annotate(text, (x[-1], times[-1]), va="center", fontsize=9, color=INK)
    axes.margins(y=0.1)
    low, high = axes.get_xlim()
    is_log = axes.get_xscale() == "log"
    # Space for the names.
    axes.set_xlim(low, high * (high / low) ** 0.35 if is_log else high + 0.25 * (high - low))


def _draw_parts(axes: Axes, figures: Figures) -> None:
    loop = figures["loop"]
    systems = {PARTS.get(name, name): ms for name, ms in loop["systems_ms_per_s"].items()}
    plant, framework = "plant, rotors, propellers", "Drake's events, caches and ports"
    parts = systems | {plant: loop["plant_ms_per_s"], framework: loop["framework_ms_per_s"]}
    names = sorted(parts, key=lambda name: -parts[name])
    styles = {plant: (INK, ""), framework: (EDGE, "///")}
    for place, name in enumerate(names):
        color, hatch = styles.get(name, (ACCENT, ""))
        axes.barh(place, parts[name], 0.7, color=color, hatch=hatch, edgecolor="white", zorder=2)
        text = f" {parts[name]:.1f} ms, {parts[name] / sum(parts.values()):.0%}"
        axes.annotate(text, (max(parts[name], 0), place), va="center", fontsize=9)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(0, 1.12 * max(parts.values()))
    axes.grid(axis="y", visible=False)
    whole, times = loop["closed_loop_ms_per_s"], figures["closed_loop_over_plant"]
    axes.set_title(
        f"Closed loop: {whole:.0f} ms of wall time per simulated second, {times:.1f} times the "
        f"plant alone; its parts, with a stopwatch: {sum(parts.values()):.0f} ms"
    )
    axes.set_xlabel("wall time / (ms per simulated second)")

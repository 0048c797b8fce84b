"""Table and figure of a benchmark."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.bench.peers import PEERS
from aerodrake.bench.scaling import FITTED_FROM, PEER
from aerodrake.bench.solvers import CONSTRAINED, SCENARIOS, installed_peers
from aerodrake.reports.figures import ACCENT, REFERENCE, STYLE

FILES = ("bench.json", "bench.png")
"""Files that a benchmark writes."""

COLUMNS = ("<20", *[">9"] * 6, ">12", ">8", ">8")
"""Alignment and width of the columns of the table of solvers."""

Figures = Mapping[str, Any]


def missing_peers() -> list[str]:
    """Returns one line for each solver that is not installed."""
    return [
        f"{name} is skipped, since it is not installed: pip install aerodrake[bench]"
        for name in PEERS
        if name not in installed_peers()
    ]


def bench_table(figures: Figures) -> str:
    """Returns all results as text."""
    sections = (_solvers, _settings, _scaling, _loop, _processes)
    return "\n\n".join("\n".join(section(figures)) for section in sections)


def _solvers(figures: Figures) -> list[str]:
    tick, peers = figures["tick"], figures["peers"]
    rows = [
        ("", "median", "p99", "worst", "solving", "constr.", "p99", "u_0 error", "ours/", "p99"),
        ("solver", "ms", "ms", "ms", "ms", "ms", "ms", "m, rad/s^2", "theirs", "ratio"),
        _solver("aerodrake", tick),
        *(_solver(f"  {name}", solver) for name, solver in figures["solvers"].items()),
        *(_solver(f"{n} {p['version'] or ''}", p) for n, p in peers.items()),
    ]  # fmt: skip
    statuses = [f"{100 * s:.2f} % {n}" for n, s in tick["status_shares"].items() if s]
    forming, overhead = tick["forming_median_ms"], tick["overhead_ms"]
    return [
        f"MPC tick over {tick['ticks']} ticks of {', '.join(SCENARIOS)}: forming and solving",
        *("".join(map(format, row, COLUMNS)).rstrip() for row in rows),
        f"status: {', '.join(statuses)}; forming {forming:.3f} ms of each median; "
        f"system overhead {overhead:.3f} ms",
        f"constrained: {tick['bounded']['ticks']} ticks of these and of {CONSTRAINED} with an "
        "active constraint",
    ]


def _solver(name: str, figures: Figures) -> list[str]:
    if figures["median_ms"] is None:
        return [name, "not installed"]
    times = [figures[f"{key}_ms"] for key in ("median", "p99", "worst", "solving_median")]
    constrained = [figures["bounded"][f"{key}_ms"] for key in ("median", "p99")]
    ratios = [figures.get(f"{key}_ratio") for key in ("median", "p99")]
    return [
        name,
        *("" if ms is None else f"{ms:.3f}" for ms in times + constrained),
        f"{figures['u0_error_max']:.1e}",
        *("" if ratio is None else f"{ratio:.2f}" for ratio in ratios),
    ]


def _settings(figures: Figures) -> list[str]:
    lines = [f"  {name}: {p['settings']}" for name, p in figures["peers"].items() if p["version"]]
    return ["settings of the peers", *lines]


def _scaling(figures: Figures) -> list[str]:
    scaling = figures["scaling"]
    exponent = scaling["horizon_exponent"]
    lines = [f"tick by horizon: ms ~ N^{exponent:.2f} from N = {FITTED_FROM} on"]
    for key, rows in (("N", scaling["horizon"]), ("joints", scaling["joints"])):
        lines += [_row(key, [row[key] for row in rows], 0)]
        lines += [_row(f"{name} ms", times) for name, times in _medians(rows).items()]
    return lines


def _medians(rows: Sequence[Figures]) -> dict[str, list[float]]:
    """Returns the median times in ms of the MPC, `median`, and of the peer if it is installed."""
    peers = {
        name: [row["peers_median_ms"][name] for row in rows] for name in rows[0]["peers_median_ms"]
    }
    return {"median": [row["median_ms"] for row in rows], **peers}


def _loop(figures: Figures) -> list[str]:
    loop = figures["loop"]
    whole = {"bare plant": "plant", "closed loop": "closed_loop", "flight": "flight"}
    parts = {**loop["systems_ms_per_s"], "framework": loop["framework_ms_per_s"]}
    return [
        f"closed loop over bare plant: {figures['closed_loop_over_plant']:.2f}; "
        f"a flight at {figures['real_time_factor']:.1f} x real time; "
        f"monitor and logs {100 * loop['monitor_and_log_share']:.1f} % of it",
        "ms of wall time per simulated second",
        *(_entry(name, loop[f"{key}_ms_per_s"]) for name, key in whole.items()),
        "parts of the closed loop, by a stopwatch around each Python system",
        *(_entry(name, ms) for name, ms in parts.items()),
    ]


def _processes(figures: Figures) -> list[str]:
    memory, startup = figures["memory"], figures["startup"]
    return [
        f"peak memory: {figures['peak_rss_mb']:.0f} MB for {memory['clover_s']:g} s of clover; "
        f"{figures['rss_growth_mb']:+.1f} MB from 1 s of hover to {memory['hover_s']:g} s",
        f"start-up: --help {startup['help_s']:.2f} s, "
        f"run hover --duration 1 {startup['hover_s']:.2f} s",
    ]


def _row(name: str, values: Sequence[float], digits: int = 3) -> str:
    return f"  {name:<12}" + "".join(f"{value:>9.{digits}f}" for value in values)


def _entry(name: str, ms: float) -> str:
    return f"  {name:<26}{ms:>9.2f}"


def plot_bench(figures: Figures, path: Path) -> None:
    """Writes a figure of the tick times by solver, horizon and joints, and of the loop's parts.

    Args:
        figures: Result of `bench`.
        path: Path of the PNG.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(14, 8.5), layout="constrained")
        (solvers, horizon), (loop, joints) = figure.subplots(2, 2)
        _draw_solvers(solvers, figures)
        _draw_horizon(horizon, figures["scaling"])
        _draw_loop(loop, figures["loop"])
        _draw_joints(joints, figures["scaling"])
        figure.savefig(path, dpi=110, metadata={"Software": None})


def _draw_solvers(axes: Axes, figures: Figures) -> None:
    own = {f"  {name}": solver for name, solver in figures["solvers"].items()}
    solvers = {"aerodrake": figures["tick"], **own, **figures["peers"]}
    solvers = {name: f for name, f in solvers.items() if f["median_ms"] is not None}
    for place, (name, solver) in enumerate(solvers.items()):
        color = ACCENT if name == "aerodrake" else "#495057"
        times = [solver["median_ms"], solver["p99_ms"]]
        axes.plot(times, [place, place], color=color, marker="o", markevery=[0])
        axes.plot(times[1:], [place], color=color, marker="|", markersize=14)
    axes.set_yticks(range(len(solvers)), list(solvers))
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10])
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.set_title("MPC tick: from median to p99", fontsize=10, loc="left")
    axes.set_xlabel("forming and solving / ms")


def _draw_horizon(axes: Axes, scaling: Figures) -> None:
    N = np.array([row["N"] for row in scaling["horizon"]])
    medians = _medians(scaling["horizon"])
    forming = [row["forming_median_ms"] for row in scaling["horizon"]]
    axes.loglog(N, medians["median"], marker="o", color=ACCENT, label="tick")
    axes.loglog(N, forming, marker="o", color="#74c0fc", label="forming")
    if PEER in medians:
        axes.loglog(N, medians[PEER], marker="o", color="#495057", label=PEER)
    fitted = N >= FITTED_FROM
    start = np.array(medians["median"])[fitted][0]
    axes.loglog(N[fitted], start * (N[fitted] / FITTED_FROM) ** 2, **REFERENCE, label="N^2")
    axes.set_xticks(N, list(map(str, N)), minor=False)
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    title = f"by horizon: N^{scaling['horizon_exponent']:.2f} from N = {FITTED_FROM} on"
    axes.set_title(title, fontsize=10, loc="left", parse_math=False)
    axes.set(xlabel="N", ylabel="median / ms")
    axes.legend(loc="upper left")


def _draw_loop(axes: Axes, loop: Figures) -> None:
    parts = {"bare plant": loop["plant_ms_per_s"], **loop["systems_ms_per_s"]}
    parts["framework"] = loop["framework_ms_per_s"]
    colors = ["#495057", *[ACCENT] * (len(parts) - 2), "#adb5bd"]
    axes.set_axisbelow(True)
    axes.barh(range(len(parts)), list(parts.values()), 0.7, color=colors)
    axes.set_yticks(range(len(parts)), list(parts))
    axes.invert_yaxis()
    axes.set_title("parts of the closed loop", fontsize=10, loc="left")
    axes.set_xlabel("ms per simulated second")


def _draw_joints(axes: Axes, scaling: Figures) -> None:
    n = [row["joints"] for row in scaling["joints"]]
    for name, times in _medians(scaling["joints"]).items():
        axes.plot(n, times, marker="o", color="#495057" if name == PEER else ACCENT)
    axes.set_title("by joints", fontsize=10, loc="left")
    axes.set(xlabel="joints", ylabel="median / ms", ylim=(0, None), xticks=n)

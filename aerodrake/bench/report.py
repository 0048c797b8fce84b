"""Table of a benchmark."""

from collections.abc import Mapping, Sequence
from typing import Any

from aerodrake.bench.peers import PEERS
from aerodrake.bench.scaling import FITTED_FROM
from aerodrake.bench.solvers import CONSTRAINED, SCENARIOS, installed_peers

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
        lines += [_row(f"{name} ms", times) for name, times in medians(rows).items()]
    return lines


def medians(rows: Sequence[Figures]) -> dict[str, list[float]]:
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
        "plant by physics engine, beside each other",
        *(_entry(name, ms) for name, ms in loop["engines_ms_per_s"].items()),
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

"""The MPC's tick beside its peers: the same recorded ticks through every solver."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

from aerodrake.bench.exact import exact_minimiser
from aerodrake.bench.peers import PEERS
from aerodrake.bench.ticks import OWN, RecordedTicks, Replay, program_arrays, record_ticks
from aerodrake.bench.ticks import replay as replay_ticks
from aerodrake.flight.summary import rounded
from aerodrake.model.qp.condensed_qp import QpStatus
from aerodrake.scenario.load import load_scenario

SCENARIOS = ("clover", "clover_realistic", "moving_target")
"""Whose ticks count."""

BOUNDED = "moving_target_paper"
"""Whose ticks tell what active bounds cost, for those that count meet few. It stands apart."""


@dataclass(frozen=True)
class Judged:
    """A replay of K ticks, judged.

    Attributes:
        replay: The clock's part.
        u0_error: By solver, (K,), largest |u_0 - u_0*| of all inputs, m/s^2 or rad/s^2.
        is_bounded: (K,), whether a bound is active at the optimum.
        residual: By how much the exact minimisers violate the conditions of optimality, as
            `Optimum` has it.
    """

    replay: Replay
    u0_error: Mapping[str, np.ndarray]
    is_bounded: np.ndarray
    residual: float


def installed_peers() -> tuple[str, ...]:
    """The names of those that can be imported."""
    found = []
    for name, kind in PEERS.items():
        with suppress(ImportError):
            import_module(kind.package)
            found.append(name)
    return tuple(found)


def judge(recorded: RecordedTicks, replay: Replay) -> Judged:
    """Compares what the solvers said with the exact minimisers."""
    formulation = recorded.formulation
    optima = [
        exact_minimiser(*program_arrays(formulation.form(tick)), formulation.A)
        for tick in recorded.inputs
    ]
    best = np.array([formulation.inputs(optimum.z)[0] for optimum in optima])
    return Judged(
        replay,
        {name: np.abs(u_0 - best).max(axis=1) for name, u_0 in replay.u_0.items()},
        np.array([optimum.is_bounded for optimum in optima]),
        max(optimum.residual for optimum in optima),
    )


def solver_figures(
    duration_s: float, settle_s: float, passes: int, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Records the scenarios' ticks, solves them by every solver, and says what came of it.

    Keys:
        tick: ms, of forming and solving by the solver that flies, over the ticks of
            SCENARIOS: median, p99 and worst, forming and solving apart, `bounded` for
            the ticks of these and of BOUNDED at whose optimum a bound is active; the
            largest error of u_0 (m/s^2, rad/s^2) over all of them; how the answers
            came about, as shares; and all that by scenario.
        peers: the same for each peer, with forming; `median_ratio` and `p99_ratio`
            are the tick's by the peer's. Null where one is not installed.

    Args:
        duration_s: Reference time that is flown of each scenario, at most its own.
        settle_s: Hover before it.
        passes: Through the recorded ticks.
        progress: Called with each step's name as it begins.
    """
    names = installed_peers()
    judged: dict[str, Judged] = {}
    for name in (*SCENARIOS, BOUNDED):
        scenario = load_scenario(name)
        progress(f"flight of {name}")
        recorded = record_ticks(
            replace(scenario, duration=min(duration_s, scenario.duration), settle_s=settle_s)
        )
        progress(f"solvers on {name}")
        replay = replay_ticks(recorded, {n: PEERS[n] for n in names}, passes)
        judged[name] = judge(recorded, replay)
    tick = _figures(judged, OWN)
    statuses = {name: j.replay.statuses for name, j in judged.items()}
    tick["status_shares"] = _shares(s for name in SCENARIOS for s in statuses[name])
    for name in judged:
        tick["scenarios"][name]["status_shares"] = _shares(statuses[name])
    tick["exact_residual_max"] = rounded(max(j.residual for j in judged.values()))
    peers = {}
    for name, kind in PEERS.items():
        figures = _figures(judged, name) if name in names else {"median_ms": None, "p99_ms": None}
        for key in ("median", "p99"):
            theirs = figures[f"{key}_ms"]
            figures[f"{key}_ratio"] = rounded(tick[f"{key}_ms"] / theirs) if theirs else None
        figures["package"] = kind.package
        figures["version"] = version(kind.package) if name in names else None
        figures["settings"] = kind.settings
        peers[name] = figures
    return {"tick": tick, "peers": peers}


def spread(times_ms: np.ndarray) -> dict[str, Any]:
    """Median and 99th percentile of times_ms (K,) ms; null where there is no time."""
    if not len(times_ms):
        return {"ticks": 0, "median_ms": None, "p99_ms": None}
    return {
        "ticks": len(times_ms),
        "median_ms": rounded(np.median(times_ms)),
        "p99_ms": rounded(np.percentile(times_ms, 99)),
    }


def _figures(judged: Mapping[str, Judged], solver: str) -> dict[str, Any]:
    """Of one solver, over the scenarios that count, and by scenario."""
    counted = [judged[name] for name in SCENARIOS]
    figures = _of(counted, solver)
    bounded = [j.replay.tick_ms(solver)[j.is_bounded] for j in judged.values()]
    figures["bounded"] = spread(np.concatenate(bounded))
    figures["u0_error_max"] = max(_of([j], solver)["u0_error_max"] for j in judged.values())
    figures["scenarios"] = {name: _of([j], solver) for name, j in judged.items()}
    return figures


def _of(judged: list[Judged], solver: str) -> dict[str, Any]:
    def pooled(times: Callable[[Judged], np.ndarray]) -> np.ndarray:
        return np.concatenate([times(j) for j in judged])

    return {
        **spread(pooled(lambda j: j.replay.tick_ms(solver))),
        "worst_ms": rounded(pooled(lambda j: j.replay.tick_ms(solver)).max()),
        "forming_median_ms": rounded(np.median(pooled(lambda j: j.replay.forming_ms[solver]))),
        "solving_median_ms": rounded(np.median(pooled(lambda j: j.replay.solving_ms[solver]))),
        "u0_error_max": rounded(pooled(lambda j: j.u0_error[solver]).max()),
    }


def _shares(statuses: Iterable[QpStatus]) -> dict[str, float]:
    counts = Counter(statuses)
    return {s.name.lower(): rounded(counts[s] / counts.total()) for s in QpStatus}

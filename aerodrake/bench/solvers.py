"""Comparison of the MPC's solver with others on the same recorded ticks."""

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
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.qp.solvers import SOLVERS, available_solvers
from aerodrake.scenario.load import load_scenario

SCENARIOS = ("clover", "clover_realistic", "moving_target")
"""Scenarios whose ticks are compared."""

CONSTRAINED = "moving_target_paper"
"""Scenario with many ticks with active constraints, only for the times of such ticks."""

VARIANTS = {
    "without shortcut": {"solver": "osqp", "shortcut": False},
    **{f"with {name}": {"solver": name} for name in SOLVERS if name != "osqp"},
}
"""Solvers of the MPC beside the default one: changes of the section `mpc`."""


@dataclass(frozen=True)
class EvaluatedReplay:
    """A replay of K ticks, compared with the exact minimisers.

    Attributes:
        replay: The replay, with its times.
        u0_error: By solver, (K,), largest |u_0 - u_0*| of all inputs, m/s^2 or rad/s^2.
        is_constrained: (K,), True if a constraint is active at the optimum.
        residual: Largest optimality residual of the exact minimisers, as in `Optimum`.
    """

    replay: Replay
    u0_error: Mapping[str, np.ndarray]
    is_constrained: np.ndarray
    residual: float


def installed_peers() -> tuple[str, ...]:
    """Returns the names of the peers that can be imported."""
    names = []
    for name, kind in PEERS.items():
        with suppress(ImportError):
            import_module(kind.package)
            names.append(name)
    return tuple(names)


def evaluate(recorded: RecordedTicks, replay: Replay) -> EvaluatedReplay:
    """Compares the solutions of a replay with the exact minimisers."""
    formulation = recorded.formulation
    optima = [
        exact_minimiser(*program_arrays(formulation.form(tick)), formulation.A)
        for tick in recorded.inputs
    ]
    best = np.array([formulation.inputs(optimum.z)[0] for optimum in optima])
    return EvaluatedReplay(
        replay,
        {name: np.abs(u_0 - best).max(axis=1) for name, u_0 in replay.u_0.items()},
        np.array([optimum.is_constrained for optimum in optima]),
        max(optimum.residual for optimum in optima),
    )


def solver_figures(
    duration_s: float, settle_s: float, passes: int, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Records the ticks of the scenarios and solves them by all solvers.

    Keys:
        tick: Times in ms of forming and solving by the MPC's solver over the ticks of
            SCENARIOS: median, p99 and worst, and the medians of both parts; `bounded` for the
            ticks of these and of CONSTRAINED with an active constraint at the optimum;
            the largest error of u_0 (m/s^2, rad/s^2) over all of them; fractions of the
            statuses; and all of these by scenario.
        solvers: The same for each of VARIANTS that this machine has.
        peers: The same for each peer, with forming; `median_ratio` and `p99_ratio`
            are those of the MPC over those of the peer. Null if a peer is not installed.

    Args:
        duration_s: Reference time flown of each scenario, at most its own duration.
        settle_s: Hover before it.
        passes: Number of passes through the recorded ticks.
        progress: Called with the name of each step at its start.
    """
    names = installed_peers()
    available = available_solvers()
    variants = {name: own for name, own in VARIANTS.items() if own["solver"] in available}
    evaluations: dict[str, EvaluatedReplay] = {}
    for name in (*SCENARIOS, CONSTRAINED):
        scenario = load_scenario(name)
        progress(f"flight of {name}")
        recorded = record_ticks(
            replace(scenario, duration=min(duration_s, scenario.duration), settle_s=settle_s)
        )
        progress(f"solvers on {name}")
        replay = replay_ticks(recorded, {n: PEERS[n] for n in names}, passes, variants)
        evaluations[name] = evaluate(recorded, replay)
    tick, *others = (_own_figures(evaluations, name) for name in (OWN, *variants))
    tick["exact_residual_max"] = rounded(max(e.residual for e in evaluations.values()))
    peers = {}
    for name, kind in PEERS.items():
        peers[name] = figures = {"package": kind.package, "settings": kind.settings}
        figures["version"] = version(kind.package) if name in names else None
        figures |= _figures(evaluations, name) if name in names else spread(np.zeros(0))
        for key in ("median", "p99"):
            theirs = figures[f"{key}_ms"]
            figures[f"{key}_ratio"] = rounded(tick[f"{key}_ms"] / theirs) if theirs else None
    return {"tick": tick, "solvers": dict(zip(variants, others, strict=True)), "peers": peers}


def spread(times_ms: np.ndarray) -> dict[str, Any]:
    """Returns median and 99th percentile of times_ms (K,) ms; None without times."""
    if not len(times_ms):
        return {"ticks": 0, "median_ms": None, "p99_ms": None}
    return {
        "ticks": len(times_ms),
        "median_ms": rounded(np.median(times_ms)),
        "p99_ms": rounded(np.percentile(times_ms, 99)),
    }


def _figures(evaluations: Mapping[str, EvaluatedReplay], solver: str) -> dict[str, Any]:
    """Returns the results of one solver over SCENARIOS, and by scenario."""
    figures = _pooled([evaluations[name] for name in SCENARIOS], solver)
    by_scenario = {name: _pooled([e], solver) for name, e in evaluations.items()}
    constrained = [e.replay.tick_ms(solver)[e.is_constrained] for e in evaluations.values()]
    figures["bounded"] = spread(np.concatenate(constrained))
    figures["u0_error_max"] = max(own["u0_error_max"] for own in by_scenario.values())
    figures["scenarios"] = by_scenario
    return figures


def _own_figures(evaluations: Mapping[str, EvaluatedReplay], solver: str) -> dict[str, Any]:
    """Returns `_figures` of a solver of the MPC with the fractions of its statuses."""
    figures = _figures(evaluations, solver)
    statuses = {name: e.replay.statuses[solver] for name, e in evaluations.items()}
    figures["status_shares"] = _fractions(s for name in SCENARIOS for s in statuses[name])
    for name in evaluations:
        figures["scenarios"][name]["status_shares"] = _fractions(statuses[name])
    return figures


def _pooled(evaluations: list[EvaluatedReplay], solver: str) -> dict[str, Any]:
    """Returns the results of one solver over all ticks of some evaluations."""
    tick_ms = np.concatenate([e.replay.tick_ms(solver) for e in evaluations])
    forming_ms = np.concatenate([e.replay.forming_ms[solver] for e in evaluations])
    solving_ms = np.concatenate([e.replay.solving_ms[solver] for e in evaluations])
    return {
        **spread(tick_ms),
        "worst_ms": rounded(tick_ms.max()),
        "forming_median_ms": rounded(np.median(forming_ms)),
        "solving_median_ms": rounded(np.median(solving_ms)),
        "u0_error_max": rounded(max(e.u0_error[solver].max() for e in evaluations)),
    }


def _fractions(statuses: Iterable[QpStatus]) -> dict[str, float]:
    counts = Counter(statuses)
    return {s.name.lower(): rounded(counts[s] / counts.total()) for s in QpStatus}

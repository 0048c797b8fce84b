"""Benchmark suite: MPC tick, closed loop, scaling, memory and start-up."""

import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from aerodrake.bench.loop import loop_figures
from aerodrake.bench.processes import process_figures
from aerodrake.bench.scaling import scaling_figures
from aerodrake.bench.solvers import solver_figures
from aerodrake.flight.summary import rounded
from aerodrake.support.version import __version__


@dataclass(frozen=True)
class Effort:
    """Durations in simulated time, and numbers of repetitions; the defaults are those of `FULL`.

    Attributes:
        duration_s, settle_s: Reference time of the recorded flights, and hover before it.
        passes: Number of passes through recorded ticks.
        scaling_s: Duration of the flights for each horizon and number of joints.
        loop_s: Duration of the simulations of closed loop and bare plant.
        repeats: Number of these simulations.
        starts: Number of starts of each timed command.
        clover_s, hover_s: Reference time of the flights whose memory is measured.
    """

    duration_s: float = 30.0
    settle_s: float = 3.0
    passes: int = 3
    scaling_s: float = 1.0
    loop_s: float = 10.0
    repeats: int = 5
    starts: int = 3
    clover_s: float = 30.0
    hover_s: float = 600.0


FULL = Effort()
QUICK = Effort(
    duration_s=1.2,
    settle_s=0.3,
    passes=2,
    scaling_s=0.3,
    loop_s=2.0,
    repeats=3,
    starts=1,
    clover_s=2.0,
    hover_s=20.0,
)
STEPS = 16
"""Number of calls of `progress` by `bench`."""


def bench(effort: Effort, progress: Callable[[str], None] = lambda step: None) -> dict[str, Any]:
    """Runs all benchmarks one after another on one thread.

    Keys: `tick` and `peers` of `solver_figures`; `scaling`, the result of `scaling_figures`;
    the keys of `loop_figures`, with the MPC's overhead as `overhead_ms` in `tick`; the keys
    of `process_figures`; `version`; `is_quick`; and `machine`.

    Args:
        effort: `FULL` or `QUICK`.
        progress: Called with the name of each step at its start.
    """
    load = os.getloadavg()[0]
    figures = solver_figures(effort.duration_s, effort.settle_s, effort.passes, progress)
    figures["scaling"] = scaling_figures(effort.scaling_s, effort.passes, progress)
    loop = loop_figures(effort.loop_s, effort.repeats, progress)
    figures["tick"]["overhead_ms"] = loop.pop("mpc_overhead_ms")
    figures |= loop
    figures |= process_figures(effort.clover_s, effort.hover_s, effort.starts, progress)
    return {
        "version": __version__,
        "is_quick": effort is QUICK,
        "machine": {
            "system": platform.platform(),
            "cores": os.cpu_count(),
            "load_before": rounded(load),
            "python": platform.python_version(),
            "drake": version("drake"),
            "numpy": version("numpy"),
        },
        **figures,
    }

"""What the closed loop costs beside its physics, and where that goes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from aerodrake.bench.bare_plant import make_bare_plant
from aerodrake.bench.systems import timed_systems
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import rounded
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from aerodrake.support.threads import single_thread
from aerodrake.support.tick_timer import TickTimer

SCENARIO = "clover"
MPC = "mpc"


@dataclass(frozen=True)
class Cost:
    """Of simulating one diagram for some time.

    Attributes:
        wall_s: By the clock.
        cpu_s: Of this process.
    """

    wall_s: float
    cpu_s: float


def loop_figures(
    simulated_s: float, repeats: int, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Simulates the bare plant, the closed loop and the whole flight in turn.

    Keys:
        closed_loop_over_plant: Least wall time of the closed loop by that of the bare
            plant; `closed_loop_over_plant_cpu` the same of processor time.
        real_time_factor: Of the whole flight, with monitor and logs.
        loop: ms of wall time a simulated second, of `plant`, `closed_loop` and
            `flight`; the share that monitor and logs have of the flight; `systems`, each
            Python system's, by the file that holds it, as measured by a stopwatch around
            all its callbacks in simulations of their own, the MPC's in two parts; and
            `framework`, what is left of these beside the bare plant: events, caches,
            ports, the stopwatch, and systems in C++ that the plant alone does not have.
        mpc_overhead_ms: Of one tick: its event beside forming and solving.

    Args:
        simulated_s: Of each simulation.
        repeats: Of each, in turn.
        progress: Called with each step's name as it begins.
    """
    progress("closed loop beside bare plant")
    scenario = replace(load_scenario(SCENARIO), duration=simulated_s, settle_s=0.0)
    plant, closed_loop, flight = (
        make_bare_plant(scenario), make_closed_loop(scenario), FlightSimulation(scenario)
    )  # fmt: skip
    flight.fly()  # What compiles, compiles here.
    plants, loops, flights = [], [], []
    for _ in range(repeats):
        plants.append(_cost(plant, scenario))
        loops.append(_cost(closed_loop, scenario))
        flights.append(flight.fly().wall_s)
    plant_s, loop_s = (min(cost.wall_s for cost in costs) for costs in (plants, loops))
    plant_cpu_s, loop_cpu_s = (min(cost.cpu_s for cost in costs) for costs in (plants, loops))
    per_second = 1e3 / simulated_s
    progress("time by system")
    systems, timed_ms, overhead_ms = _by_system(scenario, repeats)
    return {
        "closed_loop_over_plant": rounded(loop_s / plant_s),
        "closed_loop_over_plant_cpu": rounded(loop_cpu_s / plant_cpu_s),
        "real_time_factor": rounded(simulated_s / min(flights)),
        "mpc_overhead_ms": rounded(overhead_ms),
        "loop": {
            "plant_ms_per_s": rounded(plant_s * per_second),
            "closed_loop_ms_per_s": rounded(loop_s * per_second),
            "flight_ms_per_s": rounded(min(flights) * per_second),
            "monitor_and_log_share": rounded(1 - loop_s / min(flights)),
            "systems_ms_per_s": {name: rounded(ms) for name, ms in systems.items()},
            "framework_ms_per_s": rounded(timed_ms - sum(systems.values()) - plant_s * per_second),
        },
    }


def _cost(diagram: Diagram, scenario: Scenario) -> Cost:
    """Of simulating it from trim."""
    simulator = Simulator(diagram, make_context(diagram, scenario.seed))
    simulator.Initialize()
    with single_thread():
        wall, cpu = time.perf_counter(), time.process_time()
        simulator.AdvanceTo(scenario.duration)
        return Cost(time.perf_counter() - wall, time.process_time() - cpu)


def _by_system(scenario: Scenario, repeats: int) -> tuple[dict[str, float], float, float]:
    """(ms a simulated second by system, the largest first; of the whole; ms of overhead a tick).

    All of the fastest of the repeats.
    """
    with timed_systems() as seconds:
        closed_loop = make_closed_loop(scenario)
    timer = TickTimer(closed_loop.GetSubsystemByName("coordinator").GetSubsystemByName(MPC))
    best, whole_s, ticks = {}, np.inf, 0
    for _ in range(repeats):
        seconds.clear()
        timer.times_ms.clear()
        wall_s = _cost(closed_loop, scenario).wall_s
        if wall_s < whole_s:
            best, whole_s, ticks = dict(seconds), wall_s, len(timer.times_ms)
            best["mpc_forming_and_solving"] = 1e-3 * sum(timer.times_ms)
    best["mpc_overhead"] = best.pop(MPC) - best["mpc_forming_and_solving"]
    ordered = sorted(best.items(), key=lambda item: -item[1])
    per_second = 1e3 / scenario.duration
    return (
        {name: per_second * s for name, s in ordered},
        per_second * whole_s,
        1e3 * best["mpc_overhead"] / ticks,
    )

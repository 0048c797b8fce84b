"""Cost of the closed loop relative to its plant, and cost of each system."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from aerodrake.bench.bare_plant import make_bare_plant
from aerodrake.bench.engines import engine_figures
from aerodrake.bench.systems import timed_systems
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import rounded
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from aerodrake.support.threads import single_thread
from aerodrake.support.tick_times import time_ticks

SCENARIO = "clover"
MPC = "mpc"


def loop_figures(
    simulated_s: float, repeats: int, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Simulates the bare plant, the closed loop and the whole flight alternately.

    Keys:
        closed_loop_over_plant: Ratio of the least wall times of closed loop and bare plant;
            `closed_loop_over_plant_cpu` is the same for CPU time.
        real_time_factor: Simulated time over wall time of the flight, with monitor and logs.
        loop: Wall time in ms per simulated second of `plant`, `closed_loop` and `flight`;
            `engines`, that of the plant in both physics engines, of `engine_figures`;
            fraction of monitor and logs in the flight; `systems`, the time of each Python
            system by its module, measured by a stopwatch around all its callbacks in
            separate simulations, with the MPC in two parts; and `framework`, the rest of
            these beyond the bare plant: events, caches, ports, the stopwatch, and C++
            systems that the bare plant does not have.
        mpc_overhead_ms: Time of one tick's event without forming and solving.

    Args:
        simulated_s: Duration of each simulation.
        repeats: Number of simulations of each.
        progress: Called with the name of each step at its start.
    """
    progress("closed loop beside bare plant")
    scenario = replace(load_scenario(SCENARIO), duration=simulated_s, settle_s=0.0)
    plant, closed_loop = make_bare_plant(scenario), make_closed_loop(scenario)
    flight = FlightSimulation(scenario)
    flight.fly()  # Compiles the equations.
    plants, loops, flights = [], [], []
    for _ in range(repeats):
        plants.append(_wall_and_cpu_s(plant, scenario))
        loops.append(_wall_and_cpu_s(closed_loop, scenario))
        flights.append(flight.fly().wall_s)
    (plant_s, plant_cpu_s), (loop_s, loop_cpu_s) = np.min(plants, axis=0), np.min(loops, axis=0)
    flight_s, per_second = min(flights), 1e3 / simulated_s
    progress("plant in both engines")
    engines = engine_figures(scenario, repeats)
    progress("time by system")
    systems, timed_ms, overhead_ms = _by_system(scenario, repeats)
    return {
        "closed_loop_over_plant": rounded(loop_s / plant_s),
        "closed_loop_over_plant_cpu": rounded(loop_cpu_s / plant_cpu_s),
        "real_time_factor": rounded(simulated_s / flight_s),
        "mpc_overhead_ms": rounded(overhead_ms),
        "loop": {
            "plant_ms_per_s": rounded(plant_s * per_second),
            "engines_ms_per_s": engines,
            "closed_loop_ms_per_s": rounded(loop_s * per_second),
            "flight_ms_per_s": rounded(flight_s * per_second),
            "monitor_and_log_share": rounded(1 - loop_s / flight_s),
            "systems_ms_per_s": {name: rounded(ms) for name, ms in systems.items()},
            "framework_ms_per_s": rounded(timed_ms - sum(systems.values()) - plant_s * per_second),
        },
    }


def _wall_and_cpu_s(diagram: Diagram, scenario: Scenario) -> tuple[float, float]:
    """Returns wall time and CPU time of a simulation from trim."""
    simulator = Simulator(diagram, make_context(diagram, scenario.seed))
    simulator.Initialize()
    with single_thread():
        wall, cpu = time.perf_counter(), time.process_time()
        simulator.AdvanceTo(scenario.duration)
        return time.perf_counter() - wall, time.process_time() - cpu


def _by_system(scenario: Scenario, repeats: int) -> tuple[dict[str, float], float, float]:
    """Measures the time of each system in the fastest of the repeats.

    Returns:
        ms per simulated second by system, the largest first; of the whole simulation; and
        the MPC's overhead in ms per tick.
    """
    with timed_systems() as seconds:
        closed_loop = make_closed_loop(scenario)
    times_ms = time_ticks(closed_loop.GetSubsystemByName("coordinator").GetSubsystemByName(MPC))
    best, whole_s, ticks = {}, np.inf, 0
    for _ in range(repeats):
        seconds.clear()
        times_ms.clear()
        wall_s, _ = _wall_and_cpu_s(closed_loop, scenario)
        if wall_s < whole_s:
            best, whole_s, ticks = dict(seconds), wall_s, len(times_ms)
            best["mpc_forming_and_solving"] = 1e-3 * sum(times_ms)
    best["mpc_overhead"] = best.pop(MPC) - best["mpc_forming_and_solving"]
    per_second = 1e3 / scenario.duration
    ordered = sorted(best.items(), key=lambda item: -item[1])
    systems = {name: per_second * s for name, s in ordered}
    return systems, per_second * whole_s, 1e3 * best["mpc_overhead"] / ticks

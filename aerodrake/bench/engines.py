"""Cost of the plant in both physics engines."""

import time
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from aerodrake.bench.bare_plant import make_bare_plant
from aerodrake.flight.summary import rounded
from aerodrake.scenario import Physics, Scenario
from aerodrake.support.threads import single_thread


def engine_figures(scenario: Scenario, repeats: int) -> dict[str, float]:
    """Simulates the bare plant in each engine alternately, and MuJoCo's own steps.

    Returns:
        Least wall time in ms per simulated second of `drake`, `mujoco`, and `mujoco_steps` without
        the system around them. Without MuJoCo only that of `drake`.
    """
    engines = ("drake", "mujoco") if find_spec("mujoco") else ("drake",)
    plants = {
        name: make_bare_plant(replace(scenario, physics=Physics(engine=name))) for name in engines
    }
    tasks: dict[str, Callable[[], None]] = {
        name: _simulation(plant, scenario.duration) for name, plant in plants.items()
    }
    if "mujoco" in plants:
        engine = plants["mujoco"].GetSubsystemByName("plant").engine
        steps = round(scenario.duration / engine.model.opt.timestep)
        tasks["mujoco_steps"] = lambda: engine.advance(steps)
    least = dict.fromkeys(tasks, float("inf"))
    with single_thread():
        for _ in range(repeats):
            for name, task in tasks.items():
                start = time.perf_counter()
                task()
                least[name] = min(least[name], time.perf_counter() - start)
    return {name: rounded(1e3 * s / scenario.duration) for name, s in least.items()}


def _simulation(plant: Diagram, seconds: float) -> Callable[[], None]:
    """Returns a function that simulates the plant from trim."""
    return lambda: Simulator(plant).AdvanceTo(seconds)

"""Searches each model's best weights on paths other than the clover: SCENARIO SETS [k_e].

Both try as many: those of START, the scenario's, some about START (Sobol), the others downhill
(Nelder-Mead). All else stays, K_e too unless asked for. A set costs the mean error over a lap.
"""

import sys
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from aerodrake.comparison.compare import make_variants
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.scenario import FigureEight, Lissajous, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.support.processes import run_parallel

START = {"w_2_base": 1e-3, "w_2_joints": 10.0, "w_3_base": 30.0, "w_3_joints": 30.0, "w_4": 300.0}
PATHS = ((FigureEight(), 15.0), (Lissajous(), 19.0))  # And how long a lap takes, s.


def weighted(scenario: Scenario, start: dict, decades: np.ndarray) -> Scenario:
    """The scenario with the weights of `start`, each changed by so many decades."""
    weights = [w * 10**d for w, d in zip(start.values(), decades, strict=True)]
    rounded = {name: float(f"{w:.3g}") for name, w in zip(start, weights, strict=True)}
    per = {name: (w,) * (1 if name.endswith("joints") else 3) for name, w in rounded.items()}
    return replace(scenario, mpc=replace(scenario.mpc, **per))


def cost(scenarios: list[Scenario], start: dict, decades: np.ndarray) -> float:
    """m, the mean error of all scenarios on all paths."""
    errors = []
    for scenario in scenarios:
        for path, duration in PATHS:
            flown = replace(weighted(scenario, start, decades), reference=path, duration=duration)
            errors.append(summarize(flown, FlightSimulation(flown).fly())["error"]["lap_mean_m"])
    return float(np.mean([1.0 if error is None else error for error in errors]))


def search(item: tuple[list[Scenario], dict, int]) -> tuple[float, Scenario]:
    """The lowest cost, and the scenario that has it, of so many sets of weights."""
    scenarios, start, sets = item
    spread = qmc.Sobol(len(start), seed=0).random(8) - 0.5
    own = np.log10([getattr(scenarios[0].mpc, key)[0] / w for key, w in start.items()])
    tried = {tuple(d): cost(scenarios, start, d) for d in [0 * own, own, *spread]}
    first = np.array(min(tried, key=tried.__getitem__))
    options = {"maxfev": max(1, sets - len(tried))}
    options["initial_simplex"] = first + np.vstack([0 * first, 0.2 * np.eye(len(first))])
    best = minimize(partial(cost, scenarios, start), first, method="Nelder-Mead", options=options)
    return best.fun, weighted(scenarios[0], start, best.x)


def main(name: str = "clover_paper", sets: str = "40", gain: str = "") -> None:
    variants = make_variants(scenario := load_scenario(name))
    own = ["modified+offline", "modified+online"] if scenario.residual.checkpoint else ["modified"]
    models = {"integral": ["integral"], "modified": own}
    start = START | ({gain: 4.0} if gain else {})
    items = [([variants[v] for v in chosen], start, int(sets)) for chosen in models.values()]
    for index, (error, best) in run_parallel(search, items, len(items)):
        print(f"{list(models)[index]}, {1e3 * error:.2f} mm:")
        print(*(f"  {w}: {list(getattr(best.mpc, w))}" for w in start), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:4])

"""Searches the best weights of each model on paths other than the clover: SCENARIO SETS [k_e].

Each model gets as many sets: START, the scenario's, some near START (Sobol), then Nelder-Mead.
The cost is the mean error over a lap. K_e is searched if named. Prints a baseline file of
`aerodrake compare` (integral model) and a section `mpc` (modified model).
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
PATHS = ((FigureEight(), 15.0), (Lissajous(), 19.0))  # With the duration of a lap, s.


def weighted(scenario: Scenario, start: dict, decades: np.ndarray) -> Scenario:
    """Returns the scenario with the weights `start`, each scaled by 10 to its `decades`."""
    weights = [w * 10**d for w, d in zip(start.values(), decades, strict=True)]
    rounded = {name: float(f"{w:.3g}") for name, w in zip(start, weights, strict=True)}
    per = {name: (w,) * (1 if name.endswith("joints") else 3) for name, w in rounded.items()}
    return replace(scenario, mpc=replace(scenario.mpc, **per))


def cost(scenarios: list[Scenario], start: dict, decades: np.ndarray) -> float:
    """Returns the mean error of all scenarios on all paths, in m."""
    errors = []
    for scenario in scenarios:
        for path, duration in PATHS:
            flown = replace(weighted(scenario, start, decades), reference=path, duration=duration)
            errors.append(summarize(flown, FlightSimulation(flown).fly())["error"]["lap_mean_m"])
    return float(np.mean([1.0 if error is None else error for error in errors]))


def search(item: tuple[list[Scenario], dict, int]) -> tuple[float, Scenario]:
    """Returns the lowest cost of a number of sets of weights, and the scenario with that cost."""
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
    start = START | ({gain: 4.0} if gain else {})
    items = [([variants[v] for v in names], start, int(sets)) for names in (["integral"], own)]
    for index, (error, best) in run_parallel(search, items, len(items)):
        head, indent = [("# integral", ""), ("# modified\nmpc:", "  ")][index]
        print(f"# {1e3 * error:.2f} mm", head, sep="\n")
        print(*(f"{indent}{w}: {list(getattr(best.mpc, w))}" for w in start), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:4])

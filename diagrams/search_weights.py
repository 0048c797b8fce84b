"""Searches each model's best weights on paths other than the clover: SCENARIO SETS.

Both try as many sets of weights: the scenario's, some spread over a decade about them (Sobol),
the others downhill (Nelder-Mead). W_1 stays, since only ratios matter; so does all else. A set
costs the mean error over a lap, 1 m where the vehicle is lost. The modified model flies twice,
with its network as trained and learning online.
"""

import sys
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from aerodrake.compare import make_variants
from aerodrake.processes import run_parallel
from aerodrake.reference_kinds import FigureEight, Lissajous
from aerodrake.scenario import Scenario
from aerodrake.scenario_file import load_scenario
from aerodrake.simulate import Flight
from aerodrake.summary import summarize

MODELS = {"integral": ("integral",), "modified": ("modified+offline", "modified+online")}
WEIGHTS = ("w_2_base", "w_2_joints", "w_3_base", "w_3_joints", "w_4")
PATHS = ((FigureEight(), 15.0), (Lissajous(), 19.0))  # And how long a lap takes, s.


def weighted(scenario: Scenario, decades: np.ndarray) -> Scenario:
    """The scenario with each weight changed by so many decades."""
    old = [getattr(scenario.mpc, name) for name in WEIGHTS]
    new = [tuple(float(f"{w * 10**d:.3g}") for w in o) for o, d in zip(old, decades, strict=True)]
    return replace(scenario, mpc=replace(scenario.mpc, **dict(zip(WEIGHTS, new, strict=True))))


def cost(scenarios: list[Scenario], decades: np.ndarray) -> float:
    """m, the mean error of all scenarios on all paths."""
    errors = []
    for scenario in scenarios:
        for path, duration in PATHS:
            flown = replace(weighted(scenario, decades), reference=path, duration=duration)
            errors.append(summarize(flown, Flight(flown).fly())["error"]["lap_mean_m"])
    return float(np.mean([1.0 if error is None else error for error in errors]))


def search(item: tuple[list[Scenario], int]) -> tuple[float, Scenario]:
    """The lowest cost, and the scenario that has it, of so many sets of weights."""
    scenarios, sets = item
    spread = qmc.Sobol(len(WEIGHTS), seed=0).random(8) - 0.5
    tried = {tuple(d): cost(scenarios, d) for d in [np.zeros(len(WEIGHTS)), *spread]}
    start = np.array(min(tried, key=tried.__getitem__))
    simplex = start + np.vstack([0 * start, 0.2 * np.eye(len(start))])
    options = {"maxfev": max(1, sets - len(tried)), "initial_simplex": simplex}
    best = minimize(lambda d: cost(scenarios, d), start, method="Nelder-Mead", options=options)
    return best.fun, weighted(scenarios[0], best.x)


def main(name: str = "clover_paper", sets: int = 40) -> None:
    variants = make_variants(load_scenario(name))
    items = [([variants[v] for v in chosen], sets) for chosen in MODELS.values()]
    for index, (error, best) in run_parallel(search, items, len(items)):
        print(f"{list(MODELS)[index]}, {1e3 * error:.2f} mm:")
        print(*(f"  {w}: {list(getattr(best.mpc, w))}" for w in WEIGHTS), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:2], *(int(n) for n in sys.argv[2:3]))

"""Searches each model's best weights on paths other than the clover: SCENARIO SETS.

Both try as many sets of weights: those of START, some spread over a decade about them (Sobol),
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
START = {"w_2_base": 1e-3, "w_2_joints": 10.0, "w_3_base": 30.0, "w_3_joints": 30.0, "w_4": 300.0}
PATHS = ((FigureEight(), 15.0), (Lissajous(), 19.0))  # And how long a lap takes, s.


def weighted(scenario: Scenario, decades: np.ndarray) -> Scenario:
    """The scenario with START's weights, each changed by so many decades."""
    weights = [w * 10**d for w, d in zip(START.values(), decades, strict=True)]
    rounded = {name: float(f"{w:.3g}") for name, w in zip(START, weights, strict=True)}
    per = {name: (w,) * (1 if name.endswith("joints") else 3) for name, w in rounded.items()}
    return replace(scenario, mpc=replace(scenario.mpc, **per))


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
    spread = qmc.Sobol(len(START), seed=0).random(8) - 0.5
    tried = {tuple(d): cost(scenarios, d) for d in [np.zeros(len(START)), *spread]}
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
        print(*(f"  {w}: {list(getattr(best.mpc, w))}" for w in START), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:2], *(int(n) for n in sys.argv[2:3]))

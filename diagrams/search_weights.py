"""Searches the MPC's weights with which each model flies best, on paths that are not the clover.

    python diagrams/search_weights.py [SCENARIO] [FLIGHTS]

Both models start from the scenario's weights and have the same number of flights:
first spread over two decades about them (Sobol), then downhill (Nelder-Mead). W_1
stays, since the ratios alone matter. All else, flight controller and gains, is the
scenario's. A flight's cost is its mean error over a lap; a lost one costs 1 m.
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

MODELS = ("integral", "modified+online")
WEIGHTS = ("w_2_base", "w_2_joints", "w_3_base", "w_3_joints", "w_4")
PATHS = (FigureEight(), Lissajous())


def weighted(scenario: Scenario, decades: np.ndarray) -> Scenario:
    """The scenario with each weight changed by so many decades."""
    weights = {
        name: tuple(float(f"{w * 10**d:.3g}") for w in getattr(scenario.mpc, name))
        for name, d in zip(WEIGHTS, decades, strict=True)
    }
    return replace(scenario, mpc=replace(scenario.mpc, **weights))


def cost(scenario: Scenario) -> float:
    """m, the mean error over a lap, averaged over the paths."""
    errors = []
    for path in PATHS:
        lap_s = path.lap_s if isinstance(path, FigureEight) else max(path.period_s)
        flown = replace(scenario, reference=path, duration=path.start_s + lap_s)
        summary = summarize(flown, Flight(flown).fly())
        error = summary["error"]["lap_mean_m"]
        errors.append(error if summary["exit_reason"] == "completed" and error else 1.0)
    return float(np.mean(errors))


def search(item: tuple[Scenario, int]) -> tuple[float, Scenario]:
    """The best cost and the scenario that has it, after so many evaluations."""
    scenario, budget = item
    spread = 2 * qmc.Sobol(len(WEIGHTS), seed=0).random(max(1, budget // 3)) - 1
    tried = {tuple(d): cost(weighted(scenario, d)) for d in [np.zeros(len(WEIGHTS)), *spread]}
    start = min(tried, key=tried.__getitem__)
    simplex = np.vstack([start, start + 0.3 * np.eye(len(WEIGHTS))])
    best = minimize(
        lambda d: cost(weighted(scenario, d)),
        start,
        method="Nelder-Mead",
        options={"maxfev": budget - len(tried), "initial_simplex": simplex},
    )
    return best.fun, weighted(scenario, best.x)


def main(name: str = "clover_paper", budget: int = 60) -> None:
    variants = make_variants(load_scenario(name))
    items = [(variants[model], budget) for model in MODELS]
    for index, (best, scenario) in run_parallel(search, items, len(items)):
        print(f"{MODELS[index]}: {1e3 * best:.2f} mm")
        for weight in WEIGHTS:
            print(f"  {weight}: {list(getattr(scenario.mpc, weight))}")


if __name__ == "__main__":
    main(*sys.argv[1:2], *(int(n) for n in sys.argv[2:3]))

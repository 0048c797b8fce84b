"""Comparison of variants of one flight."""

import os
import weakref
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from aerodrake.api.comparison_result import ComparisonResult
from aerodrake.api.console import Console
from aerodrake.api.jobs import checked_jobs
from aerodrake.comparison.compare import (
    comparison_notes,
    fly_variants,
    load_baseline,
    make_variants,
    own_variant,
)
from aerodrake.comparison.engines import DRAKE, engine_variants
from aerodrake.comparison.equal import equal_variants, share_margins, share_results
from aerodrake.comparison.margins import find_margins
from aerodrake.comparison.page import Comparison
from aerodrake.flight.log import FlightLog
from aerodrake.flight.notes import scenario_notes
from aerodrake.flight.summary import headline
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import frozen
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput
from aerodrake.support.scratch import temporary_folder


@checked
def compare(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    *,
    variants: str | Sequence[str] = (),
    baseline: str | os.PathLike[str] | None = None,
    margins: bool = False,
    engines: bool = False,
    jobs: int | None = None,
    quiet: bool = False,
    **keys: Any,
) -> ComparisonResult:
    """Flies variants of a scenario, and compares them with each other and with the paper.

        comparison = aerodrake.compare("clover_paper", variants=["integral", "modified"])
        comparison.flight("modified").error["max_m"]

    Args:
        scenario, overrides, keys: As for `aerodrake.fly`.
        variants: One name or several of `aerodrake.comparison.compare.VARIANTS`; empty for all
            that differ from each other.
        baseline: YAML file with the weights of `integral_best`; None for the packaged file of
            the scenario's name, or the default weights.
        margins: True to search the delay, rotor thrust and payload at which the error of each
            variant doubles, and at which its flight is not completed.
        engines: True to fly the scenario itself in both physics engines instead, as `drake` and
            `mujoco`.
        jobs: Number of concurrent processes; None for the number of cores.
        quiet: True to print no notes and show no progress.

    Raises:
        BadInput: if the scenario, a name or the baseline is invalid, a variant cannot be flown, or
            engines are to be compared with variants or a baseline, or without MuJoCo.
    """
    console, jobs = Console(quiet), checked_jobs(jobs)
    scenario = resolve(scenario, overrides, **keys)
    file = None if baseline is None else Path(baseline)
    names = [variants] if isinstance(variants, str) else variants
    if engines and (names or file):
        given = "variants" if names else "baseline"
        raise BadInput("engines", "", f"expected no {given} with it, since the scenario is flown")
    with ExitStack() as stack:
        flown = stack.enter_context(frozen(scenario))
        folder = stack.enter_context(temporary_folder())
        if engines:
            chosen, notes = engine_variants(flown), []
        else:
            chosen = make_variants(flown, names, load_baseline(flown, file))
            notes = comparison_notes(flown)
        console.note([*scenario_notes(flown), *notes])
        equal = equal_variants(chosen)
        distinct = {name: variant for name, variant in chosen.items() if name not in equal}
        with console.bar(flown.name, len(distinct), "variant") as bar:
            summaries = fly_variants(distinct, folder, jobs, lambda name: bar.update())
        summaries = share_results(summaries, equal, chosen, folder)
        vehicle = VehicleModel.load(flown)  # The same in all variants.
        logs = {
            name: FlightLog.read(folder / name / "log.npz", summary, vehicle)
            for name, summary in summaries.items()
            if summary["exit_reason"] != "failed"
        }
        searched = None
        if margins:
            with console.bar(f"{flown.name} margins", None, "flight") as bar:
                searched = find_margins(distinct, summaries, headline(summaries), jobs, bar.update)
            searched = share_margins(searched, equal, chosen)
        own = DRAKE if engines else own_variant(flown)
        comparison = Comparison(flown, chosen, own, summaries, logs, searched)
        result = ComparisonResult(comparison, scenario, file, folder)
        weakref.finalize(result, stack.pop_all().close)  # Removes the folder of the flights.
    return result

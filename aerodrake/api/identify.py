"""Identification of K_B."""

import os
import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from aerodrake.api.console import Console
from aerodrake.api.identification_result import IdentificationResult
from aerodrake.api.jobs import checked_jobs
from aerodrake.identification.identify import DURATION_S, FLIGHTS, identify_gains
from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import frozen
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked


@checked
def identify(
    scenario: Scenario | str | os.PathLike[str] = "clover_paper",
    overrides: Mapping[str, Any] | None = None,
    *,
    jobs: int | None = None,
    quiet: bool = False,
    **keys: Any,
) -> IdentificationResult:
    """Identifies K_B, the gain of the base with its flight controller in the equivalent model.

    Six flights of 60 s excite the base along each axis, with the arm still and moving.

        k_b = aerodrake.identify("clover_paper", {"flight.position_gain": [16, 16, 16]}).k_b

    Args:
        scenario, overrides, keys: As for `aerodrake.fly`; the reference is ignored.
        jobs: Number of concurrent processes; None for the number of cores.
        quiet: True to show no progress.

    Raises:
        BadInput: if the scenario is invalid, or the response of the base is not of first order.
        ProcessDied: if the process of a flight died.
    """
    console, jobs = Console(quiet), checked_jobs(jobs)
    scenario = resolve(scenario, overrides, **keys)
    with ExitStack() as stack:
        flown = stack.enter_context(frozen(scenario))
        with console.flight_bar(f"identify {scenario.name}", FLIGHTS * DURATION_S) as bar:
            result = IdentificationResult(identify_gains(flown, jobs, progress=bar.update))
        weakref.finalize(result, stack.pop_all().close)  # Removes the copies of its files.
    return result

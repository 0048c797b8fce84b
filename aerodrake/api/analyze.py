"""Linear analysis of the closed loop."""

import os
import weakref
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from aerodrake.analysis.analyze import HOVER_STEPS, analyze_loop
from aerodrake.api.analysis_result import AnalysisResult
from aerodrake.api.console import Console
from aerodrake.flight.notes import scenario_notes
from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import frozen
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput


@checked
def analyze(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    *,
    times: float | Sequence[float] = (),
    quiet: bool = False,
    **keys: Any,
) -> AnalysisResult:
    """Linearises the closed loop of a scenario in hover, and finds its modes and margins.

        analysis = aerodrake.analyze("clover", {"arm.inertia": "diagonal"})
        print(analysis.sentence, analysis.modes[0].participants)

    The loop has the unconstrained MPC, and neither noise nor gusts.

    Args:
        scenario, overrides, keys: As for `aerodrake.fly`.
        times: s, reference times at which the loop is linearised about the flight as well.
        quiet: True to print no notes and show no progress.

    Raises:
        BadInput: if the scenario is invalid, or a time is not within its flight.
    """
    console = Console(quiet)
    scenario = resolve(scenario, overrides, **keys)
    instants = times if isinstance(times, Sequence) else [times]
    for time in instants:
        if not 0 <= time <= scenario.duration:
            expected = f"expected times in [0, {scenario.duration:g}] s"
            raise BadInput("analyze", "times", f"{expected}, got {time:g}")
    with ExitStack() as stack:
        analysed = stack.enter_context(frozen(scenario))
        console.note(scenario_notes(analysed))
        steps = HOVER_STEPS + len({*instants})
        with console.bar(f"analyze {scenario.name}", steps, "step") as bar:

            def progress(step: str) -> None:
                bar.set_postfix_str(step, refresh=False)
                bar.update()

            analysis = analyze_loop(analysed, instants, progress)
        result = AnalysisResult(analysis, scenario, analysed)
        weakref.finalize(result, stack.pop_all().close)  # Removes the copies of its files.
    return result

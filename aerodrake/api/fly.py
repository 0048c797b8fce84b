"""One flight."""

import os
import weakref
from collections.abc import Mapping
from contextlib import ExitStack, nullcontext
from typing import Any

from aerodrake.analysis.instability import hover_instability
from aerodrake.api.console import FLIGHT_BAR, LIVE_BAR, Console
from aerodrake.api.flight_result import FlightResult
from aerodrake.flight.notes import scenario_notes
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.reports.live import LiveView
from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import frozen
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked
from aerodrake.support.garbage import frozen_garbage
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.wire.interface import make_lcm
from aerodrake.wire.remote_coordinator import make_station_link
from aerodrake.wiring.replacements import Replacements


@checked
def fly(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    *,
    replacements: Replacements | None = None,
    view: LiveView | None = None,
    lcm: str | None = None,
    quiet: bool = False,
    **keys: Any,
) -> FlightResult:
    """Flies a scenario.

        result = aerodrake.fly("clover", duration=3)
        result = aerodrake.fly("clover", {"mpc.horizon": 10, "wind.velocity_m_s": [2, 0, 0]})

    An interrupt (Ctrl-C) ends the flight; the result is of the time that was flown.

    Args:
        scenario: A packaged name, the path of a YAML file, or a scenario.
        overrides: Values by dotted key that replace the scenario's, as for `load_scenario`.
        replacements: Replacements of systems in the closed loop; None for none.
        view: Shows the flight in a browser while it is flown, in real time or at the view's rate.
        lcm: URL over which a coordinator in another process flies the vehicle, in real time;
            None for a coordinator in this process.
        quiet: True to print no notes and show no progress.
        **keys: The same as `overrides`, as keyword arguments.

    Raises:
        BadInput: if the scenario, one of its files, a replacement or the URL is invalid.
        ProcessDied: if the connection to the remote coordinator fails.
    """
    console = Console(quiet)
    scenario = resolve(scenario, overrides, **keys)
    with ExitStack() as stack:
        flown = stack.enter_context(frozen(scenario))
        console.note(scenario_notes(flown))
        link = make_station_link(flown, make_lcm(lcm), console.say) if lcm else None
        flight = FlightSimulation(flown, replacements, link)
        total_s = flown.settle_s + flown.duration
        with (
            console.flight_bar(flown.name, total_s, LIVE_BAR if view else FLIGHT_BAR) as bar,
            view or nullcontext(),
            deferred_interrupts() as check,
            frozen_garbage() if link else nullcontext(),
        ):

            def progress(simulated_s: float) -> None:
                if view:
                    bar.set_postfix_str(view.line(), refresh=False)
                bar.update(simulated_s - bar.n)
                check()  # Ends the flight; its results are kept.

            if link:
                console.say(f"note: waiting in trim for a coordinator at {lcm}")
            rate = view.rate if view else 1.0 if link else 0.0
            log = flight.fly(progress, rate, view.attach if view else lambda *_: None)
        summary = summarize(flown, log)
        # The analysis is of the packaged systems.
        summary["instability"] = None if replacements else hover_instability(flown, log)
        result = FlightResult(scenario, summary, log, lambda: flight.closed_loop, flown)
        weakref.finalize(result, stack.pop_all().close)  # Removes the copies of its files.
    return result

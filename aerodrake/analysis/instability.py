"""Instability of the hover as the explanation of a flight that ended early."""

import logging
from dataclasses import replace

from aerodrake.analysis.analyze import analyze_hover
from aerodrake.flight.log import FlightLog
from aerodrake.scenario import Scenario

_log = logging.getLogger(__name__)

NOT_ANALYSED = ("completed", "interrupted")
"""Exit reasons of flights whose loop is not analysed."""


def hover_instability(scenario: Scenario, log: FlightLog) -> str | None:
    """Returns the sentence of an unstable hover of a flight that was lost or left NOMINAL.

    None if the loop is stable in hover, the flight was completed or interrupted, a fault of the
    scenario had begun, or a command is at its limit in hover, which is another cause. None as well
    if the analysis fails, which is logged at the level `INFO`.
    """
    has_fault = any(fault.start_s < log.time_s[-1] for fault in scenario.faults)
    if log.exit_reason in NOT_ANALYSED or has_fault:
        return None
    try:
        hover = analyze_hover(replace(scenario, faults=()))
        return None if hover.is_stable or hover.saturated else hover.sentence
    except (Exception, SystemExit) as error:  # Drake raises SystemExit if a check fails.
        _log.info("hover of %s is not analysed: %s", scenario.name, error)
        return None

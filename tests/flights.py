"""Logs of flights that nobody would like to fly."""

from dataclasses import replace

import numpy as np

from aerodrake.flight.log import FlightLog


def lost_early(log: FlightLog, samples: int, cause: str = "") -> FlightLog:
    """A flight that was lost after so many samples, the last of which is no number."""
    signals = {key: rows[:samples].copy() for key, rows in log.signals.items()}
    for key in ("quaternion", "p_B_m", "q_rad", "p_E_m"):
        signals[key][-1] = np.nan
    return replace(log, signals=signals, exit_reason="lost", exit_cause=cause)

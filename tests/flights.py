"""Logs of flights that end badly."""

from dataclasses import replace

import numpy as np

from aerodrake.flight.log import FlightLog


def lost_early(log: FlightLog, samples: int, cause: str = "") -> FlightLog:
    """Returns a log of a flight that is lost after so many samples, the last one NaN."""
    signals = {key: rows[:samples].copy() for key, rows in log.signals.items()}
    for key in ("quaternion", "p_B_m", "q_rad", "p_E_m"):
        signals[key][-1] = np.nan
    return replace(log, signals=signals, exit_reason="lost", exit_cause=cause)

"""What the supervisor noticed on a flight, and when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from aerodrake.flight_log import FlightLog
from aerodrake.model.safe_mode import SafeMode
from aerodrake.model.supervision import Condition


def events(conditions: Sequence[Condition], log: FlightLog) -> list[dict[str, Any]]:
    """Each trigger and clearing of a condition, in order of time.

    Keys:
        time_s: Reference time.
        cause: The condition's name.
        mode: What it asks for, a `SafeMode`'s label.
        event: `triggered` or `cleared`.
    """
    active = log["conditions"] > 0.5
    changes = np.diff(active, axis=0, prepend=np.zeros((1, active.shape[1]), dtype=bool))
    return [
        {
            "time_s": float(log.time_s[row]),
            "cause": conditions[i].name,
            "mode": conditions[i].mode.label,
            "event": "triggered" if active[row, i] else "cleared",
        }
        for row, i in zip(*np.nonzero(changes), strict=True)
    ]


def safe_modes(log: FlightLog, period: float) -> dict[str, float]:
    """s in each safe mode, by its label, of samples `period` s apart; 0 where it was not in it."""
    samples = np.bincount(log["supervisor_mode"][:-1].astype(int), minlength=len(SafeMode))
    return {mode.label: float(round(samples[mode] * period, 9)) for mode in SafeMode}

"""Identification without flights: samples of a first-order base take their place."""

import numpy as np
import pytest

from aerodrake.identification import identify
from aerodrake.identification.identify import Manoeuvre, Record
from tests.in_this_process import in_this_process

K_B = (1.5, 2.0, 2.5)
"""1/s, of the ideal base."""


def replace_flights(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replaces the flights by samples of a first-order base with `K_B`, in this process."""

    def fly(manoeuvre: Manoeuvre) -> Record:
        t = 0.02 * np.arange(1000)
        error = 0.1 * np.cos(t)
        return Record(t, error, 0 * t, K_B[manoeuvre.axis] * error)

    monkeypatch.setattr(identify, "fly", fly)
    monkeypatch.setattr(identify, "run_parallel", in_this_process)

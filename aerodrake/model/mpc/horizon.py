"""The stages of the MPC's horizon."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from aerodrake.scenario import Mpc


def stage_ticks(config: Mpc) -> np.ndarray:
    """(N,) how many ticks each stage lasts: longer the further away, 1 at first.

    They grow geometrically, rounded to ticks, so that `config.horizon` stages
    last `config.span_ticks` in all. Where there are as many stages as ticks or
    more, each lasts one.
    """
    N, span = config.horizon, config.span_ticks
    if span <= N:
        return np.ones(N, dtype=int)
    powers = np.arange(N)
    ratio = brentq(lambda growth: np.sum(growth**powers) - span, 1.0, span ** (1 / (N - 1)))
    ends = np.round(np.cumsum(ratio**powers)).astype(int)
    ends = np.maximum.accumulate(np.maximum(ends, powers + 1))
    return np.sort(np.diff(ends, prepend=0))


def stage_times(config: Mpc, period: float) -> np.ndarray:
    """(N + 1,) s, from now to the end of each stage, 0 first, for ticks every `period` s."""
    return period * np.append(0, np.cumsum(stage_ticks(config)))

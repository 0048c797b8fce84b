"""Identification of K_B: a gain by least squares, with its confidence interval."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

LEVEL = 0.95
"""Level of the confidence interval."""


@dataclass(frozen=True)
class GainFit:
    """Fit of v = k (p_d - p) + constant to one axis.

    Attributes:
        gain: k, 1/s.
        interval: 1/s, confidence interval of k at `LEVEL`.
        r2: Fraction of the velocity's variance that the fit explains.
    """

    gain: float
    interval: tuple[float, float]
    r2: float


def fit_gain(error: Sequence[np.ndarray], velocity: Sequence[np.ndarray], block: int) -> GainFit:
    """Fits one gain to several records, each with a constant of its own.

    Samples of one flight are correlated, so that the usual standard error is far too small.
    The interval is that of the jackknife over blocks of time (H. R. Kuensch, "The
    jackknife and the bootstrap for general stationary observations", 1989), with
    Student's t. A block is left out of all records at once, since records with a common
    excitation have common errors. It covers noise, and the variation of the gain from
    block to block, as over the frequencies of a chirp. White noise on p reduces the gain
    by the ratio of its variance to that of p_d - p.

    Args:
        error: (T,) m of each record, p_d - p.
        velocity: (T,) m/s of each record, v, or v - v_d if the flight controller receives v_d.
        block: Samples per block, more than the correlation length of the residual. Each record
            has at least two blocks; remaining samples belong to its last.
    """
    count = min(map(len, error)) // block
    blocks = []
    residual_power = power = 0.0
    centred = [(e - e.mean(), v - v.mean()) for e, v in zip(error, velocity, strict=True)]
    gain = sum(e @ v for e, v in centred) / sum(e @ e for e, _ in centred)
    for e, v in centred:
        starts = np.arange(count) * block
        blocks.append(np.add.reduceat(np.stack([e * v, e * e]), starts, axis=1))
        residual_power += ((v - gain * e) ** 2).sum()
        power += (v**2).sum()
    parts = np.sum(blocks, axis=0)
    without = np.divide(*(parts.sum(axis=1, keepdims=True) - parts))
    deviation = np.sqrt((count - 1) / count * ((without - without.mean()) ** 2).sum())
    reach = student.ppf((1 + LEVEL) / 2, count - 1) * deviation
    interval = (float(gain - reach), float(gain + reach))
    return GainFit(float(gain), interval, float(1 - residual_power / power))

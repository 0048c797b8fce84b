"""Encoders of the joints: resolution, and rates as filtered differences of angles."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.scenario import JointSensors
from aerodrake.support.compiled import compiled


class Encoder(NamedTuple):
    """Resolution and rates of the encoders.

    Attributes:
        quantum_rad: rad, step of the measured angles; 0 for exact ones.
        is_difference: True for rates by difference, False for exact ones.
        filter_s: s, time constant of the low-pass filter of the differences; 0 for none.
    """

    quantum_rad: float
    is_difference: bool
    filter_s: float

    @classmethod
    def make(cls, config: JointSensors) -> Self:
        """Returns the encoders of a scenario."""
        quantum_rad = 2 * np.pi / 2**config.resolution_bits if config.resolution_bits else 0.0
        return cls(quantum_rad, config.rate == "difference", config.rate_filter_s)

    def rate_deviation(self, angle: float, dt: float) -> float:
        """Returns the standard deviation in rad/s of the noise on measured rates.

        The filtered difference is a moving average of white noise, to which rounding adds that of
        a uniform distribution.

        Args:
            angle: rad, standard deviation of the noise on the angles.
            dt: s, between samples.
        """
        if not self.is_difference:
            return 0.0
        gain = -np.expm1(-dt / self.filter_s) if self.filter_s > 0 else 1.0
        deviation = np.hypot(angle, self.quantum_rad / np.sqrt(12))
        return float(deviation / dt * gain * np.sqrt(2 / (2 - gain)))

    @classmethod
    def exact(cls) -> Self:
        """Returns encoders of exact angles and rates."""
        return cls(0.0, False, 0.0)


@compiled
def quantized(encoder: Encoder, q: np.ndarray) -> np.ndarray:
    """Returns the multiples of the quantum that are nearest to the angles q (n,) rad."""
    if encoder.quantum_rad == 0:
        return q.copy()
    return encoder.quantum_rad * np.rint(q / encoder.quantum_rad)


@compiled
def differentiated(
    encoder: Encoder, rate: np.ndarray, q_last: np.ndarray, q: np.ndarray, dt: float
) -> np.ndarray:
    """Returns the rates (n,) rad/s by difference, after a first-order low-pass filter.

    Args:
        encoder: Its filter, which is exact for a difference that is constant over `dt`.
        rate: (n,) rad/s, at the last sample.
        q_last, q: (n,) rad, angles as measured at the last sample and at this one.
        dt: s, between both stamps; the rates do not change if it is not positive.
    """
    if dt <= 0:
        return rate.copy()
    gain = 1.0 - np.exp(-dt / encoder.filter_s) if encoder.filter_s > 0 else 1.0
    return rate + gain * ((q - q_last) / dt - rate)

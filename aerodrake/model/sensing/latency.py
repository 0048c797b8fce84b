"""Latency and loss of samples, from uniform draws."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.scenario import Sensors

DRAWS = 10
"""Number of uniform draws of all sensors: the latencies of each, then the losses."""


class Delivery(NamedTuple):
    """Delivery of samples, by sensor: position, attitude, joints, accelerometer and tool.

    Attributes:
        delay: (5,) plant steps, known delay.
        least: (5,) plant steps, least latency beyond it.
        span: (5,) plant steps, from the least to the largest latency.
        loss: (5,) probability that a sample does not arrive.
        is_stamped: (5,) True for stamps of the time of sampling, False for those of arrival.
        step: s, a plant step.
    """

    delay: np.ndarray
    least: np.ndarray
    span: np.ndarray
    loss: np.ndarray
    is_stamped: np.ndarray
    step: float

    @classmethod
    def make(cls, config: Sensors, step: float) -> Self:
        """Returns the delivery of a scenario's samples, with plant steps of `step` s."""
        base, sensors = config.base_delay_s, config.each.values()
        delay = np.array([base, base, 0.0, base, config.tool.delay_s])
        bounds = np.rint(np.array([sensor.latency_s for sensor in sensors]) / step).astype(int)
        return cls(
            np.rint(delay / step).astype(int),
            bounds[:, 0],
            bounds[:, 1] - bounds[:, 0],
            np.array([sensor.loss for sensor in sensors]),
            np.array([sensor.stamp == "sampling" for sensor in sensors]),
            step,
        )

    @property
    def has_latency(self) -> bool:
        """True if a sample of position, attitude or joints has a latency beyond the known delay."""
        return bool((self.least + self.span)[:3].any())

    @property
    def is_random(self) -> bool:
        """True if a latency or a loss is drawn."""
        return bool(self.span.any() or self.loss.any())

    @property
    def longest(self) -> int:
        """Longest delay of a sample in plant steps."""
        return int((self.delay + self.least + self.span).max())

    def latency(self, draws: np.ndarray) -> np.ndarray:
        """Returns the latencies (5,) in plant steps for the draws (10,), each equally likely."""
        drawn = np.minimum((draws[: len(self.span)] * (self.span + 1)).astype(int), self.span)
        return self.least + drawn

    def is_lost(self, sensor: int, draws: np.ndarray) -> bool:
        """Returns True if the sample of a sensor does not arrive, for the draws (10,)."""
        return bool(draws[len(self.span) + sensor] < self.loss[sensor])

    def stamp(self, sensor: int, time_s: float, draws: np.ndarray) -> float:
        """Returns the time stamp in s of a sample that arrives at `time_s`, for the draws (10,)."""
        late = self.latency(draws)[sensor] if self.is_stamped[sensor] else 0
        return time_s - late * self.step

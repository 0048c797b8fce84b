"""Messages with setpoints that arrive late, out of order, or not at all."""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.setpoint.integration import evaluate
from aerodrake.scenario import Actuation
from aerodrake.support.compiled import compiled

LOST_S = 1e9
"""s, latency of a message that is lost; finite, as all states."""


class LinkTiming(NamedTuple):
    """Timing of the messages.

    Attributes:
        low, high: s, smallest and largest latency.
        loss: Probability that a message is lost.
        period: s, from one message to the next.
        silence_s: s, time after which setpoints stop if no other message arrives.
    """

    low: float
    high: float
    loss: float
    period: float
    silence_s: float

    @classmethod
    def make(cls, config: Actuation, period: float, ticks: int) -> Self:
        """Returns the timing of a link with a message each `period` s.

        Args:
            config: Latency and loss.
            period: s.
            ticks: Number of periods for which a message is followed.
        """
        low, high = config.setpoint_latency_s
        return cls(low, high, config.setpoint_loss, period, ticks * period)

    @property
    def pending(self) -> int:
        """Largest number of messages that are on their way, or overtaken, at a tick."""
        return max(1, math.ceil(self.high / self.period - 1e-9))


@compiled
def latency(timing: LinkTiming, draws: np.ndarray) -> float:
    """Returns the latency in s of a message; `LOST_S` if it is lost.

    Args:
        timing: Its distribution.
        draws: (2,) uniform draws from [0, 1), for latency and loss.
    """
    if draws[1] < timing.loss:
        return LOST_S
    return timing.low + (timing.high - timing.low) * draws[0]


@compiled
def sent(messages: np.ndarray, segment: np.ndarray, latency_s: float) -> np.ndarray:
    """Returns the messages after one more was sent.

    Args:
        messages: (1 + K, 3 m + 1) `Segment`s in the order in which they were sent. Their times are
            those of their arrival. The first has arrived; by now the second has, or is lost.
        segment: (3 m + 1,) the `Segment` that is sent at its own time.
        latency_s: s.
    """
    after = messages.copy()
    if messages[1, -1] < LOST_S:
        after[0] = messages[1]
    after[1:-1] = messages[2:]
    after[-1] = segment
    after[-1, -1] += latency_s
    return after


@compiled
def newest(messages: np.ndarray, time: float) -> np.ndarray:
    """Returns the last sent of the messages (K, 3 m + 1) that have arrived at a time in s."""
    for i in range(len(messages) - 1, 0, -1):
        if messages[i, -1] <= time:
            return messages[i]
    return messages[0]


@compiled
def followed(
    message: np.ndarray, time: float, silence_s: float, first: int, end: int
) -> np.ndarray:
    """Returns position, velocity and acceleration of some axes of a message, as `evaluate`.

    The setpoints rest where they are `silence_s` s after the arrival.
    """
    last = message[-1] + silence_s
    setpoint = evaluate(message, min(time, last), first, end)
    if time > last:
        setpoint[end - first :] = 0.0
    return setpoint

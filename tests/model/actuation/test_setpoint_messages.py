"""Messages with setpoints: latency, order and loss."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.actuation.setpoint_messages import (
    LOST_S,
    LinkTiming,
    followed,
    latency,
    newest,
    sent,
)
from aerodrake.model.setpoint.integration import Segment
from aerodrake.scenario import Actuation

PERIOD, AXES = 0.02, 4


def segment(k: int) -> np.ndarray:
    """Returns the segment of tick k, whose positions are k."""
    return Segment(np.full(AXES, float(k)), np.zeros(AXES), np.zeros(AXES), k * PERIOD).to_vector()


def timing(low: float, high: float, loss: float = 0.0) -> LinkTiming:
    config = Actuation(setpoint_latency_s=(low, high), setpoint_loss=loss)
    return LinkTiming.make(config, PERIOD, 5)


def test_latencies_are_uniform_and_losses_as_frequent_as_stated():
    link, draws = timing(0.005, 0.025, 0.2), np.random.default_rng(1).random((5000, 2))
    latencies = np.array([latency(link, row) for row in draws])
    lost = latencies == LOST_S
    assert np.mean(lost) == pytest.approx(0.2, abs=0.02)
    arrived = np.sort(latencies[~lost])
    expected = np.linspace(0.005, 0.025, len(arrived))
    np.testing.assert_allclose(arrived, expected, atol=0.0008)  # Kolmogorov and Smirnov.


@given(st.lists(st.floats(0, 0.07) | st.just(LOST_S), min_size=1, max_size=30), st.floats(0, 1))
def test_the_last_sent_of_those_that_arrived_is_followed(latencies, share):
    """Also at times between ticks; message 0 has arrived at time 0."""
    link = timing(0.0, 0.07)
    messages = np.tile(segment(0), (1 + link.pending, 1))
    for k, late in enumerate(latencies, 1):
        messages = sent(messages, segment(k), late)
        time = (k + share) * PERIOD
        arrived = [i + 1 for i in range(k) if (i + 1) * PERIOD + latencies[i] <= time]
        assert newest(messages, time)[0] == max(arrived, default=0)


def test_the_polynomials_begin_at_the_arrival():
    p, v, u = np.arange(4.0), np.ones(4), np.full(4, 2.0)
    messages = np.tile(segment(0), (3, 1))
    messages = sent(messages, Segment(p, v, u, 0.4).to_vector(), 0.013)
    t = 0.007
    got = followed(newest(messages, 0.413 + t), 0.413 + t, 0.1, 1, 3)
    expected = [*(p + v * t + u * t**2 / 2)[1:3], *(v + u * t)[1:3], 2, 2]
    np.testing.assert_allclose(got, expected)


def test_setpoints_rest_after_a_silence():
    message = Segment(np.zeros(3), np.ones(3), np.zeros(3), 1.0).to_vector()
    np.testing.assert_allclose(followed(message, 1.1, 0.1, 0, 3), [0.1] * 3 + [1] * 3 + [0] * 3)
    np.testing.assert_allclose(followed(message, 9.0, 0.1, 0, 3), [0.1] * 3 + [0] * 6)


@pytest.mark.parametrize(("high", "pending"), [(0.0, 1), (0.02, 1), (0.021, 2), (0.5, 25)])
def test_pending_messages(high, pending):
    assert timing(0.0, high).pending == pending

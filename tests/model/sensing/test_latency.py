"""Latency and loss: distribution, stamps, and units."""

import numpy as np
import pytest
from scipy.stats import chisquare

from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import ATTITUDE, JOINTS, POSITION, TOOL
from aerodrake.scenario import PositionSensor, Sensors, ToolSensor

STEP = 0.001
CONFIG = Sensors(
    base_delay_s=0.01,
    position=PositionSensor(latency_s=(0.002, 0.009), loss=0.3, stamp="arrival"),
    tool=ToolSensor(period_s=0.02, delay_s=0.02, latency_s=(0.0, 0.001)),
)


def test_each_latency_of_whole_steps_is_equally_likely():
    delivery = Delivery.make(CONFIG, STEP)
    draws = np.random.default_rng(0).random((20_000, DRAWS))
    late = np.array([delivery.latency(row) for row in draws])
    np.testing.assert_array_equal(late[:, [ATTITUDE, JOINTS]], 0)
    steps, counts = np.unique(late[:, POSITION], return_counts=True)
    np.testing.assert_array_equal(steps, np.arange(2, 10))
    assert chisquare(counts).pvalue > 0.01
    assert set(late[:, TOOL]) == {0, 1}


def test_no_draw_exceeds_the_largest_latency():
    late = Delivery.make(CONFIG, STEP).latency(np.ones(DRAWS))
    np.testing.assert_array_equal(late, [9, 0, 0, 0, 1])


def test_known_delays_are_those_of_base_and_tool():
    delivery = Delivery.make(CONFIG, STEP)
    np.testing.assert_array_equal(delivery.delay, [10, 10, 0, 10, 20])
    assert delivery.longest == 21


def test_samples_are_lost_with_their_probability():
    delivery = Delivery.make(CONFIG, STEP)
    draws = np.random.default_rng(1).random((10_000, DRAWS))
    lost = [delivery.is_lost(POSITION, row) for row in draws]
    assert np.mean(lost) == pytest.approx(0.3, abs=0.015)
    assert not any(delivery.is_lost(ATTITUDE, row) for row in draws)


def test_stamps_are_times_of_arrival_or_of_sampling_plus_the_known_delay():
    delivery = Delivery.make(CONFIG, STEP)
    assert delivery.stamp(POSITION, 1.0, np.ones(DRAWS)) == 1.0
    assert delivery.stamp(TOOL, 1.0, np.ones(DRAWS)) == pytest.approx(0.999)

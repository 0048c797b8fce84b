"""Encoders: a quantised ramp, and the filtered difference's step response."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.sensing.encoder import Encoder, differentiated, quantized
from aerodrake.scenario import JointSensors

angles = st.floats(-6.3, 6.3)


@given(q=angles, bits=st.integers(1, 24))
def test_angles_are_rounded_to_the_nearest_multiple(q, bits):
    encoder = Encoder.make(JointSensors(resolution_bits=bits))
    (measured,) = quantized(encoder, np.array([q]))
    assert abs(measured - q) <= np.pi / 2**bits * (1 + 1e-9)
    assert measured * 2**bits / (2 * np.pi) == pytest.approx(round(measured * 2**bits / 2 / np.pi))


def test_a_ramp_becomes_a_staircase_with_steps_of_its_resolution():
    q = np.linspace(0, 2 * np.pi, 4001)
    steps = np.diff(quantized(Encoder.make(JointSensors(resolution_bits=8)), q))
    risers = steps[steps > 0]
    np.testing.assert_allclose(risers, 2 * np.pi / 256, rtol=1e-9)
    assert len(risers) == 256


@given(q=angles)
def test_no_bits_are_exact(q):
    assert quantized(Encoder.make(JointSensors()), np.array([q])) == q


@pytest.mark.parametrize("filter_s", [0.0, 0.005, 0.05])
def test_the_step_response_is_that_of_a_first_order_filter(filter_s):
    """1 - exp(-t / tau) at the samples, of a ramp that begins at time 0."""
    encoder = Encoder.make(JointSensors(rate="difference", rate_filter_s=filter_s))
    dt, slope, rate = 0.01, np.array([2.0, -1.0]), np.zeros(2)
    for k in range(1, 11):
        rate = differentiated(encoder, rate, slope * (k - 1) * dt, slope * k * dt, dt)
        response = 1 - np.exp(-k * dt / filter_s) if filter_s else 1.0
        np.testing.assert_allclose(rate, slope * response, rtol=1e-9)


@pytest.mark.parametrize("dt", [0.0, -0.01])
def test_without_time_between_samples_the_rate_stays(dt):
    encoder, rate = Encoder.make(JointSensors(rate="difference")), np.array([0.3])
    assert differentiated(encoder, rate, np.zeros(1), np.ones(1), dt) == rate


@pytest.mark.parametrize("filter_s", [0.0, 0.005, 0.05])
def test_the_deviation_of_rates_is_that_of_white_noise_on_the_angles(filter_s):
    encoder = Encoder.make(
        JointSensors(resolution_bits=12, rate="difference", rate_filter_s=filter_s)
    )
    noise = np.random.default_rng(0).normal(size=(40, 5000)) * 0.002
    rate, dt = np.zeros(5000), 0.01
    angles = [quantized(encoder, q) for q in 0.3 + noise]
    for last, q in zip(angles[:-1], angles[1:], strict=True):
        rate = differentiated(encoder, rate, last, q, dt)
    assert rate.std() == pytest.approx(encoder.rate_deviation(0.002, dt), rel=0.03)

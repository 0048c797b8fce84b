"""What the state filter makes of samples that are late, wrong or missing, and of joints."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.sensing.sample import GROUPS, group_columns
from aerodrake.model.sensing.sample_check import SampleCheck, Verdict
from aerodrake.model.sensing.state_filter import (
    ARM_DECAY_S,
    JOINT_WALK_RAD,
    StateFilter,
    arm_follows,
    follow,
    initial_memory,
    passed,
    update,
)
from aerodrake.scenario import Filter, Sensors
from tests.estimates import CONFIG, DT, JOINTS, correct, estimate, rest, state_of


@pytest.mark.parametrize(("delay_s", "steps"), [(0.0, 0), (0.01, 1), (0.03, 3), (0.07, 7)])
def test_lateness_is_counted_in_samples(delay_s, steps):
    assert StateFilter.make(Filter(delay_s=delay_s), DT).steps == steps


def test_joints_follow_their_scalar_kalman_filter():
    """From q' = (measured rates' mean) + noise: the gain where its own recursion ends."""
    config = Filter(joint_noise_rad=0.003)
    P = 1.0
    for _ in range(1000):
        P += JOINT_WALK_RAD**2
        K = P / (P + config.joint_noise_rad**2)
        P *= 1 - K
    q, rate, new_rate, measured = np.random.default_rng(1).normal(size=(4, JOINTS))
    sample = rest(q=measured, qdot=new_rate).to_vector()
    found = correct(StateFilter.make(config, DT), estimate(q=q, qdot=rate), sample)
    predicted = q + DT * (rate + new_rate) / 2
    np.testing.assert_allclose(state_of(found).q, (1 - K) * predicted + K * measured, rtol=1e-10)
    np.testing.assert_array_equal(state_of(found).qdot, new_rate)


def test_joints_that_speed_up_steadily_are_followed_exactly():
    gains = StateFilter.make(Filter(), DT)
    start, speed_up = np.linspace(-1, 1, JOINTS), np.linspace(5, -3, JOINTS)
    now = estimate(q=start)
    for k in range(1, 51):
        t = k * DT
        sample = rest(q=start + speed_up * t**2 / 2, qdot=speed_up * t)
        now = correct(gains, follow(gains, now, np.zeros(6)), sample.to_vector())
    np.testing.assert_allclose(state_of(now).q, sample.q, atol=1e-12)


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_late_sample_corrects_the_estimate_of_its_own_time(steps):
    """All samples and accelerations at hand, the filter is run from the start each time."""
    random = np.random.default_rng(2)
    gains = StateFilter.make(replace(CONFIG, delay_s=steps * DT), DT)
    bounds = SampleCheck.make(CONFIG, Sensors(), DT)
    rows = 12
    accelerations = random.normal(size=(rows + steps, 6))
    accelerations[:steps] = accelerations[0]
    start = rest(q=np.ones(JOINTS)).to_vector()
    samples = start + 0.003 * random.normal(size=(rows, len(start)))
    memory = initial_memory(gains, start, accelerations[0])
    first = np.concatenate([-accelerations[0], start])
    for k in range(rows):
        memory, now, health = update(
            gains,
            bounds,
            memory,
            accelerations[steps + k],
            samples[k],
            np.full(3, k * DT),
            np.zeros(3 * JOINTS),
        )
        np.testing.assert_array_equal(health, 0)
        expected = first
        for a, sample in zip(accelerations[: k + 1], samples[: k + 1], strict=False):
            expected = correct(gains, follow(gains, expected, a), sample)
        for a in accelerations[k + 1 : k + 1 + steps]:
            expected = follow(gains, expected, a)
        np.testing.assert_array_equal(now, expected)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
@pytest.mark.parametrize("group", GROUPS)
def test_what_is_not_believed_is_predicted_and_the_rest_corrected(group, wrong):
    gains = StateFilter.make(CONFIG, DT)
    bounds = SampleCheck.make(CONFIG, Sensors(), DT)
    a, start = np.arange(6.0), rest(q=np.ones(JOINTS)).to_vector()
    memory = initial_memory(gains, start, np.zeros(6))
    setpoint = np.linspace(0.9, 1.1, 3 * JOINTS)
    sample, stamps = start + 1e-3, np.zeros(3)
    _, well, health = update(gains, bounds, memory, a, sample, stamps, setpoint)
    np.testing.assert_array_equal(health, 0)
    columns = group_columns(group, JOINTS)
    broken = sample.copy()
    broken[columns[-1]] = wrong
    _, found, health = update(gains, bounds, memory, a, broken, stamps, setpoint)
    expected = arm_follows(gains, follow(gains, np.append(np.zeros(6), start), a), setpoint)
    struck = np.isin(np.arange(len(start)), columns)
    np.testing.assert_array_equal(found[6:][struck], expected[6:][struck])
    np.testing.assert_array_equal(found[6:][~struck], well[6:][~struck])
    assert list(health) == [
        *[DT * (g == group) for g in GROUPS],
        *[float(Verdict.NOT_FINITE) * (g == group) for g in GROUPS],
    ]
    shown = passed(broken, found[6:], health)
    np.testing.assert_array_equal(shown[struck], expected[6:][struck])
    np.testing.assert_array_equal(shown[~struck], broken[~struck])


@given(q=arrays(float, JOINTS, elements=st.floats(-3, 3)), times=st.integers(1, 100))
def test_an_arm_without_samples_comes_to_its_setpoints(q, times):
    """Which speed up steadily: as exp(-t / ARM_DECAY_S), in rates too."""
    gains, a = StateFilter.make(CONFIG, DT), np.linspace(-2, 2, JOINTS)
    now = estimate(q=q, qdot=np.ones(JOINTS))
    for k in range(1, times + 1):
        t = k * DT
        now = arm_follows(gains, now, np.concatenate([a * t**2 / 2, a * t, a]))
    left = np.exp(-t / ARM_DECAY_S)
    np.testing.assert_allclose(state_of(now).q, a * t**2 / 2 + left * q, atol=1e-12)
    np.testing.assert_allclose(state_of(now).qdot, a * t + left, atol=1e-12)

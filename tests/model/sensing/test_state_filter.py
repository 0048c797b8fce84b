"""State filter: delayed, wrong and missing samples, and joints."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.sensing.estimate import ARM_DECAY_S, predict_arm, predict_base
from aerodrake.model.sensing.sample import GROUPS, Sample, group_columns
from aerodrake.model.sensing.sample_health import Verdict, split_health
from aerodrake.model.sensing.state_filter import (
    JOINT_WALK_RAD,
    NO_FORCE,
    FilterState,
    StateFilter,
    replace_rejected,
    update,
)
from aerodrake.scenario import Filter, Sensors
from tests.estimates import CONFIG, DT, JOINTS, correct, estimate, rest, state_of


@pytest.mark.parametrize(("delay_s", "steps"), [(0.0, 0), (0.01, 1), (0.03, 3), (0.07, 7)])
def test_the_assumed_delay_is_counted_in_samples(delay_s, steps):
    assert StateFilter.make(Filter(delay_s=delay_s), Sensors(), DT).steps == steps


def test_joints_follow_their_scalar_kalman_filter():
    """The gain is the limit of the recursion for q' = mean of the measured rates + noise."""
    config = Filter(joint_noise_rad=0.003)
    P = 1.0
    for _ in range(1000):
        P += JOINT_WALK_RAD**2
        K = P / (P + config.joint_noise_rad**2)
        P *= 1 - K
    q, rate, new_rate, measured = np.random.default_rng(1).normal(size=(4, JOINTS))
    sample = rest(q=measured, qdot=new_rate).to_vector()
    corrected = correct(StateFilter.make(config, Sensors(), DT), estimate(q=q, qdot=rate), sample)
    predicted = q + DT * (rate + new_rate) / 2
    np.testing.assert_allclose(
        state_of(corrected).q, (1 - K) * predicted + K * measured, rtol=1e-10
    )
    np.testing.assert_array_equal(state_of(corrected).qdot, new_rate)


def test_constant_joint_accelerations_are_estimated_exactly():
    gains = StateFilter.make(Filter(), Sensors(), DT)
    start, qddot = np.linspace(-1, 1, JOINTS), np.linspace(5, -3, JOINTS)
    now = estimate(q=start)
    for k in range(1, 51):
        t = k * DT
        sample = rest(q=start + qddot * t**2 / 2, qdot=qddot * t)
        now = correct(gains, predict_base(now, np.zeros(6), DT), sample.to_vector())
    np.testing.assert_allclose(state_of(now).q, sample.q, atol=1e-12)


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_delayed_sample_corrects_the_estimate_of_its_own_time(steps):
    """Against a filter that is run from the start each time."""
    random = np.random.default_rng(2)
    gains = StateFilter.make(replace(CONFIG, delay_s=steps * DT), Sensors(), DT)
    rows = 12
    accelerations = random.normal(size=(rows + steps, 6))
    accelerations[:steps] = accelerations[0]
    start = rest(q=np.ones(JOINTS)).to_vector()
    samples = start + 0.003 * random.normal(size=(rows, len(start)))
    state = FilterState.at_rest(gains, start, accelerations[0])
    first = state.estimate
    for k in range(rows):
        state, now = update(
            gains,
            state,
            Sample(samples[k], np.full(3, k * DT)),
            accelerations[steps + k],
            np.zeros(3 * JOINTS),
            NO_FORCE,
        )
        np.testing.assert_array_equal(state.check.health, 0)
        expected = first
        for a, sample in zip(accelerations[: k + 1], samples[: k + 1], strict=False):
            expected = correct(gains, predict_base(expected, a, DT), sample)
        for a in accelerations[k + 1 : k + 1 + steps]:
            expected = predict_base(expected, a, DT)
        for field, value in zip(now, expected, strict=True):
            np.testing.assert_array_equal(field, value)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
@pytest.mark.parametrize("group", GROUPS)
def test_a_rejected_group_is_predicted_and_the_others_corrected(group, wrong):
    gains = StateFilter.make(CONFIG, Sensors(), DT)
    a, start = np.arange(6.0), rest(q=np.ones(JOINTS)).to_vector()
    last = FilterState.at_rest(gains, start, np.zeros(6))
    setpoint = np.linspace(0.9, 1.1, 3 * JOINTS)
    sample = Sample(start + 1e-3, np.zeros(3))
    state, corrected = update(gains, last, sample, a, setpoint, NO_FORCE)
    np.testing.assert_array_equal(state.check.health, 0)
    columns = group_columns(group, JOINTS)
    broken = sample.state.copy()
    broken[columns[-1]] = wrong
    state, now = update(gains, last, sample._replace(state=broken), a, setpoint, NO_FORCE)
    expected = predict_arm(predict_base(last.estimate, a, DT), setpoint, DT).state
    rejected = np.isin(np.arange(len(start)), columns)
    np.testing.assert_array_equal(now.state[rejected], expected[rejected])
    np.testing.assert_array_equal(now.state[~rejected], corrected.state[~rejected])
    ages, verdicts = split_health(state.check.health)
    assert list(ages) == [DT * (g == group) for g in GROUPS]
    assert list(verdicts) == [Verdict.NOT_FINITE * (g == group) for g in GROUPS]
    output = replace_rejected(broken, now.state, state.check.health)
    np.testing.assert_array_equal(output[rejected], expected[rejected])
    np.testing.assert_array_equal(output[~rejected], broken[~rejected])


@given(q=arrays(float, JOINTS, elements=st.floats(-3, 3)), times=st.integers(1, 100))
def test_an_arm_without_samples_approaches_its_setpoints(q, times):
    """Deviations from setpoints of constant acceleration decay as exp(-t / ARM_DECAY_S)."""
    a = np.linspace(-2, 2, JOINTS)
    now = estimate(q=q, qdot=np.ones(JOINTS))
    for k in range(1, times + 1):
        t = k * DT
        now = predict_arm(now, np.concatenate([a * t**2 / 2, a * t, a]), DT)
    left = np.exp(-t / ARM_DECAY_S)
    np.testing.assert_allclose(state_of(now).q, a * t**2 / 2 + left * q, atol=1e-12)
    np.testing.assert_allclose(state_of(now).qdot, a * t + left, atol=1e-12)

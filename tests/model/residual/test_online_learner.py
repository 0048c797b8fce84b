"""The guards around the printed step: what they let through, and what they bound."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.last_layer import last_layer_step
from aerodrake.model.residual.online_learner import LearnerState, OnlineLearner
from aerodrake.scenario import Residual

M = 5
PRINTED = Residual(
    learning_rate=0.02,
    batch=4,
    max_step=0.0,
    max_drift=0.0,
    max_error_m_s=0.0,
    freeze_saturated=False,
)


def learner(config: Residual = PRINTED, **changes) -> OnlineLearner:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return OnlineLearner(replace(config, **changes), theta, np.array([1.0, 0.9, 0.8]))


def flown(ticks: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """phi and target at each tick."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(ticks, M)), rng.normal(size=(ticks, 3))


def states(of: OnlineLearner, phi, target, saturated=None) -> list[LearnerState]:
    """From the start to the last sample."""
    flags = np.zeros(len(phi)) if saturated is None else saturated
    state = of.start()
    found = [state]
    for sample in zip(phi, target, flags, strict=True):
        state = of.step(state, *sample)
        found.append(state)
    return found


def naive(of: OnlineLearner, phi, target) -> list[np.ndarray]:
    """The last B_l samples at each tick, in the ring's order, given to the printed step."""
    theta, batch, thetas = of.theta_offline, of.config.batch, [of.theta_offline]
    for k in range(len(phi)):
        window = sorted(range(max(0, k - batch + 1), k + 1), key=lambda i: i % batch)
        theta = last_layer_step(
            theta, phi[window], target[window], of.gain, of.config.learning_rate
        )
        thetas.append(theta)
    return thetas


WIDE = {"max_step": 100.0, "max_drift": 100.0, "max_error_m_s": 100.0, "freeze_saturated": True}


@pytest.mark.parametrize("guards", [{}, WIDE], ids=["off", "wide"])
@pytest.mark.parametrize("batch", [1, 4, 100])
def test_guards_that_do_not_bind_leave_the_printed_form(guards, batch):
    """Bit for bit; without `freeze_saturated` the flag changes nothing either."""
    plain = learner(batch=batch, **guards)
    phi, target = flown(30)
    saturated = np.full(30, not plain.config.freeze_saturated)
    for state, theta in zip(
        states(plain, phi, target, saturated), naive(plain, phi, target), strict=True
    ):
        np.testing.assert_array_equal(state.theta, theta)


@pytest.mark.parametrize("spoil", ["saturated", "error", "phi", "target"])
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_bad_samples_leave_no_trace(spoil, number):
    guarded = learner(max_error_m_s=20.0, freeze_saturated=True)
    phi, target = flown(20)
    bad = np.zeros(20, dtype=bool)
    bad[[0, 3, 4, 12]] = True
    clean = states(guarded, phi[~bad], target[~bad])
    assert clean[-1].seen == 16
    saturated = bad & (spoil == "saturated")
    if spoil == "error":
        target[bad] = [30.0, 0.0, 0.0]
    elif spoil != "saturated":
        {"phi": phi, "target": target}[spoil][bad, 1] = number
    dirty = states(guarded, phi, target, saturated)
    for before, after, was_bad in zip(dirty, dirty[1:], bad, strict=False):
        assert (before is after) == was_bad
    for name in ("theta", "phis", "targets", "seen"):
        np.testing.assert_array_equal(getattr(dirty[-1], name), getattr(clean[-1], name))


def test_a_sample_is_judged_by_the_offline_layer():
    """At the bound it is learned, beyond it is not, whatever was learned before."""
    guarded = learner(max_error_m_s=0.5)
    phi = np.eye(M)[0]
    predicted = guarded.gain * guarded.theta_offline[:, 0]
    astray = replace(guarded.start(), theta=guarded.theta_offline + 50.0)
    for state in (guarded.start(), astray):
        for error, is_learned in ((0.499, True), (0.501, False)):
            target = predicted + [0.0, error, 0.0]
            assert (guarded.step(state, phi, target, False) is not state) == is_learned


def test_a_learner_that_went_astray_comes_back():
    """Good samples are not refused for the errors that a bad layer makes of them."""
    guarded = learner(max_error_m_s=0.5, max_drift=10.0, learning_rate=0.1)
    phi, _ = flown(400)
    target = guarded.gain * (phi @ guarded.theta_offline.T)
    state = replace(guarded.start(), theta=guarded.theta_offline + 2.0)
    for sample in zip(phi, target, strict=True):
        state = guarded.step(state, *sample, False)
    np.testing.assert_allclose(state.theta, guarded.theta_offline, atol=1e-3)


def test_a_step_is_shortened_along_its_way():
    phi, target = flown(1)
    free, guarded = learner(), learner(max_step=0.01)
    step = states(free, phi, target)[1].theta - free.theta_offline
    short = states(guarded, phi, target)[1].theta - guarded.theta_offline
    assert np.linalg.norm(step) > 0.02
    np.testing.assert_allclose(short, step * 0.01 / np.linalg.norm(step), rtol=1e-10)


def test_a_drift_ends_at_the_nearest_point_of_the_ball():
    phi, target = flown(1)
    free, guarded = learner(), learner(max_drift=0.01)
    drift = states(free, phi, target)[1].theta - free.theta_offline
    assert np.linalg.norm(drift) > 0.02
    nearest = guarded.theta_offline + drift * 0.01 / np.linalg.norm(drift)
    np.testing.assert_allclose(states(guarded, phi, target)[1].theta, nearest, rtol=1e-12)


FINITE = st.floats(allow_nan=False, allow_infinity=False)
SAMPLE = st.tuples(*(arrays(float, size, elements=FINITE) for size in (M, 3)))
BOUND = st.floats(1e-3, 10.0)


@given(
    samples=st.lists(SAMPLE, min_size=1, max_size=15),
    max_step=st.one_of(st.just(0.0), BOUND),
    max_drift=BOUND,
    max_error=st.sampled_from([0.0, 0.5, 100.0]),
    rate=st.floats(0.0, 1.0),
)
def test_theta_stays_within_its_bounds_however_wild_the_samples(
    samples, max_step, max_drift, max_error, rate
):
    guarded = learner(
        max_step=max_step, max_drift=max_drift, max_error_m_s=max_error, learning_rate=rate
    )
    found = states(guarded, *zip(*samples, strict=True))
    for old, new in zip(found, found[1:], strict=False):
        assert np.isfinite(new.theta).all()
        assert np.linalg.norm(new.theta - guarded.theta_offline) <= max_drift * (1 + 1e-9)
        if max_step:
            assert np.linalg.norm(new.theta - old.theta) <= max_step * (1 + 1e-9)


@given(
    scale=st.sampled_from([0.1, 10.0, 1e4]),
    max_step=BOUND,
    max_drift=BOUND,
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=50)
def test_bounds_bind_where_they_are_exceeded(scale, max_step, max_drift, seed):
    """Each step is the printed one, unless that one is too long or leads out."""
    guarded = learner(max_step=max_step, max_drift=max_drift, learning_rate=1.0, batch=1)
    phi, target = flown(10, seed)
    found = states(guarded, scale * phi, scale * target)
    for k in range(10):
        old, new = found[k].theta, found[k + 1].theta
        printed = last_layer_step(
            old, scale * phi[k : k + 1], scale * target[k : k + 1], guarded.gain, 1.0
        )
        step = np.linalg.norm(printed - old)
        shortened = old + (printed - old) * min(1.0, max_step / step)
        out = np.linalg.norm(shortened - guarded.theta_offline)
        if out > max_drift:
            away = np.linalg.norm(new - guarded.theta_offline)
            assert away == pytest.approx(max_drift, rel=1e-9)
        else:
            np.testing.assert_allclose(new, shortened, rtol=1e-9, atol=1e-12)


def test_a_step_that_overflows_is_not_taken_and_passes():
    guarded = learner(max_drift=1.0)
    phi, target = flown(20)
    phi[6] = 1e200
    found = states(guarded, phi, target)
    thetas = [state.theta for state in found]
    assert all(np.isfinite(theta).all() for theta in thetas)
    # Until the sample has left the ring, nothing is learned; then again.
    for k in range(6, 6 + guarded.config.batch):
        np.testing.assert_array_equal(thetas[k + 1], thetas[6])
    assert np.any(thetas[7 + guarded.config.batch] != thetas[6])


def test_a_prediction_is_made_before_its_sample_is_learned():
    """Delta_k has learned the samples up to k-1 and knows nothing of the target k."""
    plain = learner(freeze_saturated=True)
    phi, target = flown(12)
    saturated = np.arange(12) % 5 == 2
    thetas = [state.theta for state in states(plain, phi, target, saturated)]
    delta = plain.run(phi, target, saturated)
    expected = [theta @ now for theta, now in zip(thetas, phi, strict=False)]
    np.testing.assert_array_equal(delta, expected)

    target[6] += 1.0
    np.testing.assert_array_equal(plain.run(phi, target, saturated)[:7], delta[:7])
    assert np.all(plain.run(phi, target, saturated)[7:] != delta[7:])


def test_states_are_not_changed_in_place():
    plain = learner(batch=3)
    phi, target = flown(9)
    found = states(plain, phi, target)
    kept = [(s.theta.copy(), s.phis.copy(), s.targets.copy()) for s in found]
    for sample in zip(phi, target, strict=True):
        for state in found:
            plain.step(state, *sample, False)
    for state, (theta, phis, targets) in zip(found, kept, strict=True):
        np.testing.assert_array_equal(state.theta, theta)
        np.testing.assert_array_equal(state.phis, phis)
        np.testing.assert_array_equal(state.targets, targets)

"""The closed form against autograd and torch's SGD; the guards around it."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.online_learner import LearnerState, OnlineLearner, last_layer_step
from aerodrake.scenario import Guards, Residual

# Threads that wait for each other cost a hundred times the arithmetic.
torch.set_num_threads(1)

JOINTS, M = 6, 5
PRINTED = Residual(learning_rate=0.02, batch=4, **Guards()._asdict())


def make_learner(config: Residual = PRINTED, **changes) -> OnlineLearner:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return OnlineLearner(replace(config, **changes), theta)


def make_samples(ticks: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Returns phi and target at each tick."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(ticks, M)), rng.normal(size=(ticks, 3))


def states(learner: OnlineLearner, phi, target, saturated=None) -> list[LearnerState]:
    """Returns the states from the start to the last sample."""
    flags = np.zeros(len(phi)) if saturated is None else saturated
    state = learner.start()
    history = [state]
    for sample in zip(phi, target, flags, strict=True):
        state = learner.step(state, *sample)
        history.append(state)
    return history


def naive(learner: OnlineLearner, phi, target) -> list[np.ndarray]:
    """Returns theta after each printed step on the last B_l samples, in the ring's order."""
    theta, batch, thetas = learner.theta_offline, learner.config.batch, [learner.theta_offline]
    for k in range(len(phi)):
        window = sorted(range(max(0, k - batch + 1), k + 1), key=lambda i: i % batch)
        theta = last_layer_step(theta, phi[window], target[window], learner.config.learning_rate)
        thetas.append(theta)
    return thetas


WIDE = {"max_step": 100.0, "max_drift": 100.0, "max_error_m_s": 100.0, "freeze_saturated": True}


@pytest.mark.parametrize("guards", [{}, WIDE], ids=["off", "wide"])
@pytest.mark.parametrize("batch", [1, 4, 100])
def test_inactive_guards_leave_the_printed_step_unchanged(guards, batch):
    """Bit for bit; without `freeze_saturated` the flag has no effect either."""
    plain = make_learner(batch=batch, **guards)
    phi, target = make_samples(30)
    saturated = np.full(30, not plain.config.freeze_saturated)
    for state, theta in zip(
        states(plain, phi, target, saturated), naive(plain, phi, target), strict=True
    ):
        np.testing.assert_array_equal(state.theta, theta)


@pytest.mark.parametrize("defect", ["saturated", "error", "phi", "target"])
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_rejected_samples_do_not_change_the_state(defect, number):
    guarded = make_learner(max_error_m_s=20.0, freeze_saturated=True)
    phi, target = make_samples(20)
    bad = np.zeros(20, dtype=bool)
    bad[[0, 3, 4, 12]] = True
    clean = states(guarded, phi[~bad], target[~bad])
    assert clean[-1].sample_count == 16
    saturated = bad & (defect == "saturated")
    if defect == "error":
        target[bad] = [30.0, 0.0, 0.0]
    elif defect != "saturated":
        {"phi": phi, "target": target}[defect][bad, 1] = number
    dirty = states(guarded, phi, target, saturated)
    for before, after, was_bad in zip(dirty, dirty[1:], bad, strict=False):
        assert (before is after) == was_bad
    for name in ("theta", "phis", "targets", "sample_count"):
        np.testing.assert_array_equal(getattr(dirty[-1], name), getattr(clean[-1], name))


def test_samples_are_rejected_by_the_error_of_the_offline_layer():
    """Whatever was learned before."""
    guarded = make_learner(max_error_m_s=0.5)
    phi = np.eye(M)[0]
    predicted = guarded.theta_offline[:, 0]
    diverged = guarded.start()._replace(theta=guarded.theta_offline + 50.0)
    for state in (guarded.start(), diverged):
        for error, is_learned in ((0.499, True), (0.501, False)):
            target = predicted + [0.0, error, 0.0]
            assert (guarded.step(state, phi, target, False) is not state) == is_learned


def test_a_diverged_learner_recovers():
    """Good samples are not rejected for the errors of a bad layer."""
    guarded = make_learner(max_error_m_s=0.5, max_drift=10.0, learning_rate=0.1)
    phi, _ = make_samples(400)
    target = phi @ guarded.theta_offline.T
    state = guarded.start()._replace(theta=guarded.theta_offline + 2.0)
    for sample in zip(phi, target, strict=True):
        state = guarded.step(state, *sample, False)
    np.testing.assert_allclose(state.theta, guarded.theta_offline, atol=1e-3)


def test_a_step_is_shortened_along_its_direction():
    phi, target = make_samples(1)
    unbounded, guarded = make_learner(), make_learner(max_step=0.01)
    step = states(unbounded, phi, target)[1].theta - unbounded.theta_offline
    short = states(guarded, phi, target)[1].theta - guarded.theta_offline
    assert np.linalg.norm(step) > 0.02
    np.testing.assert_allclose(short, step * 0.01 / np.linalg.norm(step), rtol=1e-10)


def test_theta_is_projected_onto_the_nearest_point_of_the_ball():
    phi, target = make_samples(1)
    unbounded, guarded = make_learner(), make_learner(max_drift=0.01)
    drift = states(unbounded, phi, target)[1].theta - unbounded.theta_offline
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
def test_theta_stays_within_its_bounds_for_any_samples(
    samples, max_step, max_drift, max_error, rate
):
    guarded = make_learner(
        max_step=max_step, max_drift=max_drift, max_error_m_s=max_error, learning_rate=rate
    )
    history = states(guarded, *zip(*samples, strict=True))
    for old, new in zip(history, history[1:], strict=False):
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
def test_bounds_act_only_where_they_are_exceeded(scale, max_step, max_drift, seed):
    """Each step is the printed one, unless that one is too long or leaves the ball."""
    guarded = make_learner(max_step=max_step, max_drift=max_drift, learning_rate=1.0, batch=1)
    phi, target = make_samples(10, seed)
    history = states(guarded, scale * phi, scale * target)
    for k in range(10):
        old, new = history[k].theta, history[k + 1].theta
        printed = last_layer_step(old, scale * phi[k : k + 1], scale * target[k : k + 1], 1.0)
        step = np.linalg.norm(printed - old)
        shortened = old + (printed - old) * min(1.0, max_step / step)
        out = np.linalg.norm(shortened - guarded.theta_offline)
        if out > max_drift:
            away = np.linalg.norm(new - guarded.theta_offline)
            assert away == pytest.approx(max_drift, rel=1e-9)
        else:
            np.testing.assert_allclose(new, shortened, rtol=1e-9, atol=1e-12)


def test_a_step_that_overflows_is_discarded():
    guarded = make_learner(max_drift=1.0)
    phi, target = make_samples(20)
    phi[6] = 1e200
    history = states(guarded, phi, target)
    thetas = [state.theta for state in history]
    assert all(np.isfinite(theta).all() for theta in thetas)
    # Nothing is learned until the sample has left the ring.
    for k in range(6, 6 + guarded.config.batch):
        np.testing.assert_array_equal(thetas[k + 1], thetas[6])
    assert np.any(thetas[7 + guarded.config.batch] != thetas[6])


def test_a_prediction_is_made_before_its_sample_is_learned():
    """Delta_k depends on the samples up to k-1, and not on the target k."""
    plain = make_learner(freeze_saturated=True)
    phi, target = make_samples(12)
    saturated = np.arange(12) % 5 == 2
    thetas = [state.theta for state in states(plain, phi, target, saturated)]
    correction = plain.run(phi, target, saturated)
    expected = [theta @ now for theta, now in zip(thetas, phi, strict=False)]
    np.testing.assert_array_equal(correction, expected)

    target[6] += 1.0
    np.testing.assert_array_equal(plain.run(phi, target, saturated)[:7], correction[:7])
    assert np.all(plain.run(phi, target, saturated)[7:] != correction[7:])


def test_states_are_not_changed_in_place():
    plain = make_learner(batch=3)
    phi, target = make_samples(9)
    history = states(plain, phi, target)
    kept = [(s.theta.copy(), s.phis.copy(), s.targets.copy()) for s in history]
    for sample in zip(phi, target, strict=True):
        for state in history:
            plain.step(state, *sample, False)
    for state, (theta, phis, targets) in zip(history, kept, strict=True):
        np.testing.assert_array_equal(state.theta, theta)
        np.testing.assert_array_equal(state.phis, phis)
        np.testing.assert_array_equal(state.targets, targets)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("batch", [1, 7, 20])
def test_steps_equal_sgd_on_the_network(seed, batch):
    """With the paper's loss, and with the squared error of Delta = target / c for any c."""
    rng = np.random.default_rng(seed)
    network = ResidualNetwork.untrained(JOINTS, seed)
    with torch.no_grad():
        network.last.weight.copy_(torch.tensor(rng.normal(size=(3, 32))))
    printed = copy.deepcopy(network)
    c, learning_rate = rng.uniform(0.01, 1, 3), 0.01
    sgds = [torch.optim.SGD(n.last.parameters(), lr=learning_rate) for n in (network, printed)]
    theta, theta_printed = c[:, None] * network.last_layer(), printed.last_layer()

    for _ in range(10):
        features, base, measured = (rng.normal(size=(batch, m)) for m in (30, 3, 3))
        phi, target, inputs = network.phi(features), measured - base, torch.tensor(features)
        theta = last_layer_step(theta, phi, target, learning_rate)
        theta_printed = last_layer_step(theta_printed, phi, target, learning_rate)
        errors = (
            network(inputs) - torch.tensor(target / c),
            torch.tensor(base) + printed(inputs) - torch.tensor(measured),
        )
        for sgd, error in zip(sgds, errors, strict=True):
            sgd.zero_grad()
            (error**2).sum(dim=1).mean().backward()
            sgd.step()
        np.testing.assert_allclose(theta, c[:, None] * network.last_layer(), rtol=0, atol=1e-12)
        np.testing.assert_allclose(theta_printed, printed.last_layer(), rtol=0, atol=1e-12)


def test_the_argument_is_not_changed():
    theta = np.zeros((3, 4))
    moved = last_layer_step(theta, np.ones((2, 4)), np.ones((2, 3)), 0.1)
    assert np.all(theta == 0) and np.all(moved == 0.2)


@pytest.mark.parametrize("ticks", [1, 3, 40])
@pytest.mark.parametrize("batch", [4, 12])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e170])
def test_the_stable_learning_rate_is_of_the_samples_in_the_ring_buffer(ticks, batch, scale):
    """The reference has the mean of the latest samples alone."""
    plain = make_learner(batch=batch)
    phi, target = make_samples(ticks)
    state = states(plain, scale * phi, 0 * target)[-1]
    latest = phi[-batch:]
    largest = np.linalg.norm(latest, 2) ** 2 / len(latest)
    assert plain.stable_learning_rate(state) == pytest.approx(1 / largest / scale / scale)


def test_an_empty_ring_buffer_has_no_stable_learning_rate():
    assert make_learner().stable_learning_rate(make_learner().start()) == 0


@pytest.mark.parametrize(("ratio", "shrinks"), [(0.99, True), (1.01, False)])
def test_stability_bound_of_the_docstring(ratio, shrinks):
    rng = np.random.default_rng(1)
    phi = rng.normal(size=(20, 5))
    largest, axis = (v[..., -1] for v in np.linalg.eigh(phi.T @ phi / len(phi)))
    theta = np.tile(axis, (3, 1))
    moved = last_layer_step(theta, phi, np.zeros((20, 3)), ratio / largest)
    assert (np.linalg.norm(moved) < np.linalg.norm(theta)) == shrinks

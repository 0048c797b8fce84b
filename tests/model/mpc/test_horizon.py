"""Stages of the horizon; states and outputs against the model, tick by tick."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from aerodrake.model.equivalent.axis_models import AXIS_MODELS
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.horizon import StageResponses, stage_ticks
from aerodrake.scenario import Model, Mpc, Scenario

K_B = (6.67, 1.8, 2.38)
TICKS = np.array([1, 1, 2, 4])
SCALE = np.array([2.0, 2.0, 2.5, 15.0, 15.0, 12.0])  # Of three joints, the last one differs.


@given(st.integers(2, 200), st.integers(1, 1000))
@example(2, 1000)
@example(200, 201)
@example(15, 15)
def test_stages_grow_from_one_tick_and_fill_the_span(horizon, span):
    ticks = stage_ticks(Mpc(horizon=horizon, span_ticks=span))
    assert ticks.shape == (horizon,) and ticks.dtype.kind == "i"
    assert ticks[0] == 1
    assert np.all(np.diff(ticks) >= 0)
    assert ticks.sum() == max(span, horizon)
    if span <= horizon:
        np.testing.assert_array_equal(ticks, 1)


@given(st.integers(3, 40), st.floats(1.1, 1.6))
def test_stages_grow_geometrically(horizon, ratio):
    """The stages of an exact geometric progression are reproduced up to rounding to ticks."""
    exact = ratio ** np.arange(horizon)
    ends = np.cumsum(exact)
    span = round(ends[-1])
    assume(span <= 1000)
    ticks = stage_ticks(Mpc(horizon=horizon, span_ticks=span))
    # Ends are rounded to half a tick, and delayed while stages would be shorter than one.
    assert np.abs(np.cumsum(ticks) / ends - 1).max() < 0.5
    assert np.abs(ticks[-1] / exact[-1] - 1) < max(0.1, 1.5 / exact[-1])


def test_the_default_spans_two_seconds_with_short_stages_first():
    ticks = stage_ticks(Mpc())
    assert len(ticks) == 15 and ticks.sum() == 100
    assert ticks[:4].max() <= 3 and 15 <= ticks[-1] <= 25


@pytest.mark.parametrize("kind", ["flight", *AXIS_MODELS])
@pytest.mark.parametrize(
    ("stage_ticks", "joints"), [([1], 6), ([1] * 15, 6), ([1, 1, 2, 3, 5], 2), ([4, 1, 7], 3)]
)
def test_states_equal_the_model_tick_by_tick(kind, stage_ticks, joints):
    """Inputs are constant over their stages, Delta over the horizon."""
    model = EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=K_B)), joints)
    stages, N = StageResponses(model, stage_ticks, np.ones(3 + joints)), len(stage_ticks)
    rng = np.random.default_rng(0)
    x, delta = rng.normal(size=len(model.A)), rng.normal(size=3)
    u = rng.normal(size=(N, 3 + joints))
    states = stages.Phi @ x + stages.Psi @ delta + stages.Gamma @ u.ravel()
    assert states.shape == (N, len(model.A))
    for k, ticks in enumerate(stage_ticks):
        for _ in range(ticks):
            x = model.predict(x, u[k], delta)
        np.testing.assert_allclose(states[k], x, atol=1e-11)


def test_states_do_not_depend_on_later_inputs():
    model = EquivalentModel.of(Scenario(), 6)
    states = StageResponses(model, [1, 2, 4], np.ones(9))
    for k in range(3):
        assert np.any(states.Gamma[k][:, 9 * k : 9 * (k + 1)] != 0)
        np.testing.assert_array_equal(states.Gamma[k][:, 9 * (k + 1) :], 0)


@pytest.mark.parametrize("kind", ["flight", "exact", "integral"])
def test_outputs_equal_those_of_the_model(kind):
    model = EquivalentModel.of(Scenario(model=Model(kind=kind)), joints=3)
    ours = StageResponses(model, TICKS, SCALE)
    rng = np.random.default_rng(0)
    x_0, delta = rng.normal(size=len(model.A)), rng.normal(size=3)
    z = rng.normal(size=(6, len(TICKS)))
    y = ours.free @ np.concatenate([x_0, delta])
    for f, axis in enumerate(ours.axis):
        y[f] += ours.G[f] @ z[axis]
    x, a = x_0, model.acceleration @ x_0
    for k, ticks in enumerate(TICKS):
        for _ in range(ticks):
            x = model.predict(x, SCALE * z[:, k], delta)
        before, a = a, model.acceleration @ x
        speeds = [*x[model.base_velocity], *x[model.joint_velocity]]
        moved = (x - x_0)[[*model.base_position, *model.joint_position]]
        expected = [*speeds, *moved, *(a - model.acceleration @ x_0)]
        np.testing.assert_allclose(y[:15, k], expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            y[15:, k], (a - before) / (ticks * model.dt), rtol=1e-9, atol=1e-9
        )

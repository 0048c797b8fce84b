"""Learning faults: their sum at a time, and an estimator that has them."""

import numpy as np
import pytest
from pydrake.systems.framework import Context

from aerodrake.model.residual.gate import GateCause
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.scenario_network import network_for
from aerodrake.scenario import (
    LearnerDiverged,
    LearnerNan,
    LearnerPoisoned,
    Push,
    Residual,
    Scenario,
)
from aerodrake.systems.faults.learner import (
    FaultyResidualEstimator,
    make_residual_estimator,
    offsets_at,
)
from aerodrake.systems.residual_estimator import ResidualEstimator
from tests.estimator_flights import (
    DT,
    JOINTS,
    OUTPUTS,
    drive,
    equivalent_model,
    fly,
    health,
    inputs,
    plain,
    steady,
    trained,
)

POISON = LearnerPoisoned(start_s=1.0, duration_s=2.0, velocity_m_s=(0.1, 0.2, 0.3))
SETTLE_S = 3.0
WARM_UP = 200
"""Ticks after which Delta is used."""
START_S = WARM_UP * DT - SETTLE_S


def offset(reference_s: float, *faults) -> np.ndarray:
    """Returns [theta, velocity], (4,) m/s."""
    return np.hstack(list(offsets_at(faults, reference_s).values()))


@pytest.mark.parametrize(
    ("reference_s", "is_on"), [(-3, 0), (0.98, 0), (1, 1), (2.98, 1), (3, 0), (99, 0)]
)
def test_a_fault_is_active_from_its_start_until_before_its_end(reference_s, is_on):
    velocity = is_on * np.array(POISON.velocity_m_s)
    np.testing.assert_array_equal(offset(reference_s, POISON), [0, *velocity])


def test_rounding_does_not_shift_a_fault_by_a_tick():
    """Ticks are multiples of a period that is no binary fraction."""
    fault = LearnerDiverged(start_s=0.1, duration_s=0.2, theta_m_s=1.0)
    on = [offset(k * 0.02 - SETTLE_S, fault)[0] for k in np.arange(0, 300)]
    np.testing.assert_array_equal(np.flatnonzero(on), np.arange(155, 165))


def test_faults_add_up():
    other = LearnerPoisoned(start_s=2.0, duration_s=2.0, velocity_m_s=(1.0, 0.0, 0.0))
    diverged = LearnerDiverged(start_s=2.5, duration_s=1.0, theta_m_s=-4.0)
    lost = LearnerNan(start_s=2.75, duration_s=0.25)
    faults = (POISON, other, diverged, lost)
    np.testing.assert_allclose(offset(2.0, *faults), [0, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(offset(2.5, *faults), [-4, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(offset(2.75, *faults), [np.nan, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(offset(3.0, *faults), [-4, 1, 0, 0])


@pytest.mark.parametrize(
    ("faults", "mode", "kind"),
    [
        ((Push(),), "online", ResidualEstimator),
        ((POISON,), "off", ResidualEstimator),
        ((Push(), POISON), "online", FaultyResidualEstimator),
    ],
)
def test_only_scenarios_with_learning_faults_and_a_learner_have_the_faulty_estimator(
    faults, mode, kind
):
    config = Residual(mode=mode)
    network = network_for(Scenario(residual=config), JOINTS)
    estimator = make_residual_estimator(network, equivalent_model(), config, faults, SETTLE_S)
    assert type(estimator) is kind


def warmed_up(*faults) -> tuple[ResidualEstimator, Context, np.ndarray]:
    """Returns an estimator that learns fast, its Context after `WARM_UP` ticks, and Delta then."""
    config = Residual(mode="online", learning_rate=0.005, gate_s=0.2)
    network = ResidualNetwork.untrained(JOINTS, 0)
    estimator = FaultyResidualEstimator(network, equivalent_model(), config, faults, SETTLE_S)
    context = estimator.CreateDefaultContext()
    log = drive(estimator, context, steady(WARM_UP))
    assert np.all(log["delta"][0] == 0) and np.all(log["delta"][-1] != 0)
    assert health(estimator, context) == (GateCause.OK, 0.0)
    return estimator, context, log["delta"][-1]


@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (LearnerNan(start_s=START_S, duration_s=DT), GateCause.NOT_FINITE),
        (LearnerDiverged(START_S, DT, theta_m_s=1e6), GateCause.DIVERGED),
    ],
)
def test_a_corrupted_layer_is_never_used_and_learning_restarts(fault, cause):
    estimator, context, last = warmed_up(fault)
    at_first = drive(estimator, context, steady(202)[200:201])["delta"][0]
    np.testing.assert_allclose(at_first, last, atol=1e-3)  # It fades out.
    assert health(estimator, context) == (cause, 0.0)
    for field in estimator.groups.learner.read(context):  # The offline layer is zero here.
        assert not np.any(field)

    delta = drive(estimator, context, steady(400)[201:])["delta"]
    zero = np.flatnonzero(~delta.any(axis=1))  # After 0.1 s, until it has helped for 0.2 s.
    assert zero[0] == 4 and np.all(np.diff(zero) == 1) and zero[-1] < 100
    assert np.all(np.diff(np.abs(delta[:4]), axis=0) < 0)
    assert health(estimator, context) == (GateCause.OK, 0.0)


def test_poisoned_labels_are_not_learned_after_detection():
    poison = LearnerPoisoned(start_s=START_S, duration_s=9.0, velocity_m_s=(0.0, 0.3, 0.0))
    estimator, context, _ = warmed_up(poison)
    delta = drive(estimator, context, steady(230)[200:])["delta"]
    assert not delta[-20:].any()
    assert health(estimator, context)[0] == GateCause.POISONED
    assert not estimator.groups.learner.read(context).theta.any()


def test_poison_changes_the_label_alone():
    """The features, and with them Delta, stay the same."""
    velocity = np.array([0.1, -0.2, 0.3])
    poison = LearnerPoisoned(start_s=0.0, duration_s=9.0, velocity_m_s=tuple(velocity))
    config, flight = plain("offline", 0.01, 20), inputs(10)
    estimator = FaultyResidualEstimator(trained(), equivalent_model(), config, [poison], 0.0)
    log = drive(estimator, estimator.CreateDefaultContext(), flight)
    clean = fly(trained(), equivalent_model(), "offline", 0.01, 20, flight)
    np.testing.assert_array_equal(log["delta"], clean["delta"])
    for name in OUTPUTS[1:]:
        np.testing.assert_allclose(log[name][1:], clean[name][1:] - velocity, atol=1e-12)

"""Flights with learning faults, against the flight without a learner."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.residual.delta_blend import DeltaSource
from aerodrake.model.residual.layer_gate import GateCause
from aerodrake.scenario import LearnerDiverged, LearnerNan, LearnerPoisoned
from aerodrake.scenario.load import load_scenario

SCENARIO = load_scenario(
    "clover_paper", {"duration": 5.0, "settle_s": 0.5, "reference.start_s": 1.0}
)


def fly(mode: str, *faults):
    residual = replace(SCENARIO.residual, mode=mode)
    return FlightSimulation(replace(SCENARIO, residual=residual, faults=faults)).fly()


@pytest.fixture(scope="module")
def off():
    return fly("off")


@pytest.fixture(scope="module")
def offline():
    return fly("offline")


def figures(log) -> np.ndarray:
    """Returns mean and maximum of the error in m, over reference time."""
    error = log.error_m[log.time_s >= 0]
    return np.array([error.mean(), error.max()])


def test_a_learner_without_faults_halves_the_error(off):
    log = fly("online")
    assert log["learner_cause"][0] == GateCause.UNPROVEN
    assert log["learner_cause"][-1] == GateCause.OK and log["learner_gated_s"][-1] == 0
    late = log.time_s > 3
    assert log.error_m[late].mean() < 0.5 * off.error_m[late].mean()


@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (LearnerNan(start_s=2.5, duration_s=0.5), GateCause.NOT_FINITE),
        (LearnerDiverged(start_s=2.5, duration_s=0.02, theta_m_s=1e6), GateCause.DIVERGED),
        (LearnerDiverged(start_s=2.5, duration_s=0.02, theta_m_s=0.005), GateCause.UNHELPFUL),
        (LearnerPoisoned(start_s=2.5, duration_s=1.0), GateCause.POISONED),
        (
            LearnerPoisoned(start_s=2.5, duration_s=9, velocity_m_s=(0, 0, -0.02)),
            GateCause.POISONED,
        ),
        (LearnerPoisoned(start_s=-1.0, duration_s=9, velocity_m_s=(99, 0, 0)), GateCause.POISONED),
    ],
)
def test_a_faulty_learner_is_gated_off_and_no_worse_than_none(off, fault, cause):
    """By at most 10 % in mean and maximum; the cause is logged, another Delta is used meanwhile."""
    log = fly("online", fault)
    assert log.exit_reason == "completed"
    assert np.all(figures(log) <= 1.1 * figures(off))
    causes, is_gated = log["learner_cause"], log["learner_cause"] != GateCause.OK
    assert cause in causes[log.time_s >= fault.start_s]
    assert np.isfinite(log["delta_m_s"]).all()
    assert np.all((log["delta_source"] != DeltaSource.LEARNED) == is_gated)
    assert not log["learner_gated_s"][~is_gated].any() and log["learner_gated_s"].max() > 0.4


@pytest.mark.parametrize(
    "fault",
    [
        LearnerNan(start_s=-1.0, duration_s=9),
        LearnerDiverged(start_s=-1.0, duration_s=9, theta_m_s=1e6),
        LearnerDiverged(start_s=-1.0, duration_s=9, theta_m_s=0.005),
    ],
)
def test_a_learner_that_never_works_flies_as_the_offline_network(offline, fault):
    """Bit for bit, and with less error than without a network."""
    log = fly("online", fault)
    assert DeltaSource.LEARNED not in log["delta_source"]
    assert log["delta_source"][-1] == DeltaSource.OFFLINE
    np.testing.assert_array_equal(log["p_E_m"], offline["p_E_m"])


def test_an_excessive_learning_rate_flies_as_the_offline_network(off, offline):
    residual = replace(SCENARIO.residual, learning_rate=0.05)
    log = FlightSimulation(replace(SCENARIO, residual=residual)).fly()
    assert np.all(figures(log) < 1.02 * figures(offline)) and figures(log)[0] < figures(off)[0]
    assert log["delta_source"][-1] == DeltaSource.OFFLINE


def test_after_a_fault_the_offline_layer_is_used_until_the_learner_helps_again():
    log = fly("online", LearnerDiverged(start_s=2.5, duration_s=0.5, theta_m_s=1e6))
    sources = log["delta_source"][log.time_s > 2]
    assert sources[np.insert(np.diff(sources) != 0, 0, True)].tolist() == [
        DeltaSource.LEARNED, DeltaSource.OFFLINE, DeltaSource.LEARNED
    ]  # fmt: skip
    delta = log["delta_m_s"][log.time_s > 1]
    jumps = np.linalg.norm(np.diff(delta, axis=0), axis=1)
    assert jumps.max() < 0.2 * np.linalg.norm(delta, axis=1).max()


def test_without_a_learner_its_faults_have_no_effect(off):
    """Bit for bit."""
    log = fly("off", LearnerNan(start_s=0.0, duration_s=9), LearnerPoisoned(start_s=0.0))
    np.testing.assert_array_equal(log["p_E_m"], off["p_E_m"])
    assert not log["learner_cause"].any()

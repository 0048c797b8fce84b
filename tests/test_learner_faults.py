"""Flights with learning faults, against the flight without a learner."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.residual.gate import FADE_OUT, GateCause
from aerodrake.scenario import LearnerDiverged, LearnerNan, LearnerPoisoned
from aerodrake.scenario.load import load_scenario

SCENARIO = load_scenario(
    "clover_paper", [("--set", f"{key}={value}") for key, value in
                     {"duration": 5.0, "settle_s": 0.5, "reference.start_s": 1.0}.items()]
)  # fmt: skip


def fly(mode: str, *faults):
    residual = replace(SCENARIO.residual, mode=mode)
    return FlightSimulation(replace(SCENARIO, residual=residual, faults=faults)).fly()


@pytest.fixture(scope="module")
def off():
    return fly("off")


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
    """By at most 10 % in mean and maximum; the cause is logged, and Delta is zero meanwhile."""
    log = fly("online", fault)
    assert log.exit_reason == "completed"
    assert np.all(figures(log) <= 1.1 * figures(off))
    causes, is_gated = log["learner_cause"], log["learner_cause"] != GateCause.OK
    assert cause in causes[log.time_s >= fault.start_s]
    assert np.isfinite(log["delta_m_s"]).all()
    assert not log["delta_m_s"][log["learner_gated_s"] > FADE_OUT * SCENARIO.residual.gate_s].any()
    assert not log["learner_gated_s"][~is_gated].any() and log["learner_gated_s"].max() > 0.4


def test_without_a_learner_its_faults_have_no_effect(off):
    """Bit for bit."""
    log = fly("off", LearnerNan(start_s=0.0, duration_s=9), LearnerPoisoned(start_s=0.0))
    np.testing.assert_array_equal(log["p_E_m"], off["p_E_m"])
    assert not log["learner_cause"].any()

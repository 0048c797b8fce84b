"""Flights with a learner that misbehaves, against the flight without one."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.residual.judge import FADE, Cause
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
    """m, mean and max over reference time."""
    error = log.error_m[log.time_s >= 0]
    return np.array([error.mean(), error.max()])


def test_a_learner_that_is_well_halves_the_error(off):
    log = fly("online")
    assert log["learner_cause"][0] == Cause.UNPROVEN
    assert log["learner_cause"][-1] == Cause.OK and log["learner_held_s"][-1] == 0
    late = log.time_s > 3
    assert log.error_m[late].mean() < 0.5 * off.error_m[late].mean()


@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (LearnerNan(start_s=2.5, duration_s=0.5), Cause.NOT_FINITE),
        (LearnerDiverged(start_s=2.5, duration_s=0.02, theta_m_s=1e6), Cause.DIVERGED),
        (LearnerDiverged(start_s=2.5, duration_s=0.02, theta_m_s=0.005), Cause.UNHELPFUL),
        (LearnerPoisoned(start_s=2.5, duration_s=1.0), Cause.POISONED),
        (LearnerPoisoned(start_s=2.5, duration_s=9, velocity_m_s=(0, 0, -0.02)), Cause.POISONED),
        (LearnerPoisoned(start_s=-1.0, duration_s=9, velocity_m_s=(99, 0, 0)), Cause.POISONED),
    ],
)
def test_one_that_misbehaves_is_given_up_and_flies_no_worse_than_none(off, fault, cause):
    """By 10 % in mean and max; its cause is told, and its Delta zero meanwhile."""
    log = fly("online", fault)
    assert log.exit_reason == "completed"
    assert np.all(figures(log) <= 1.1 * figures(off))
    causes, held = log["learner_cause"], log["learner_cause"] != Cause.OK
    assert cause in causes[log.time_s >= fault.start_s]
    assert np.isfinite(log["delta_m_s"]).all()
    assert not log["delta_m_s"][log["learner_held_s"] > FADE * SCENARIO.residual.judge_s].any()
    assert not log["learner_held_s"][~held].any() and log["learner_held_s"].max() > 0.4


def test_where_nothing_is_learned_nothing_breaks(off):
    """Bit for bit."""
    log = fly("off", LearnerNan(start_s=0.0, duration_s=9), LearnerPoisoned(start_s=0.0))
    np.testing.assert_array_equal(log["p_E_m"], off["p_E_m"])
    assert not log["learner_cause"].any()

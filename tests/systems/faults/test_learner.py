"""What the declared learning faults add up to, at which times."""

import numpy as np
import pytest

from aerodrake.scenario import (
    LearnerDiverged,
    LearnerNan,
    LearnerPoisoned,
    Push,
    Residual,
    Scenario,
)
from aerodrake.systems.faults.learner import LearnerFaultSystem, make_learner_fault

SETTLE_S = 3.0
POISON = LearnerPoisoned(start_s=1.0, duration_s=2.0, velocity_m_s=(0.1, 0.2, 0.3))


def fault_at(reference_s: float, *faults) -> np.ndarray:
    system = LearnerFaultSystem(faults, SETTLE_S)
    context = system.CreateDefaultContext()
    context.SetTime(SETTLE_S + reference_s)
    return system.GetOutputPort("fault").Eval(context)


@pytest.mark.parametrize(
    ("reference_s", "is_on"), [(-3, 0), (0.98, 0), (1, 1), (2.98, 1), (3, 0), (99, 0)]
)
def test_from_its_start_until_before_its_end(reference_s, is_on):
    velocity = is_on * np.array(POISON.velocity_m_s)
    np.testing.assert_array_equal(fault_at(reference_s, POISON), [0, *velocity])


def test_every_tick_is_in_or_out_whatever_rounding_does():
    """Ticks are multiples of a period that is no binary fraction."""
    fault = LearnerDiverged(start_s=0.1, duration_s=0.2, theta_m_s=1.0)
    ticks = np.arange(0, 300)
    on = [fault_at(k * 0.02 - SETTLE_S, fault)[0] for k in ticks]
    np.testing.assert_array_equal(np.flatnonzero(on), np.arange(155, 165))


def test_faults_add_up():
    other = LearnerPoisoned(start_s=2.0, duration_s=2.0, velocity_m_s=(1.0, 0.0, 0.0))
    diverged = LearnerDiverged(start_s=2.5, duration_s=1.0, theta_m_s=-4.0)
    lost = LearnerNan(start_s=2.75, duration_s=0.25)
    all_of_them = (POISON, other, diverged, lost)
    np.testing.assert_allclose(fault_at(2.0, *all_of_them), [0, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(fault_at(2.5, *all_of_them), [-4, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(fault_at(2.75, *all_of_them), [np.nan, 1.1, 0.2, 0.3])
    np.testing.assert_allclose(fault_at(3.0, *all_of_them), [-4, 1, 0, 0])


def test_absent_where_nothing_is_wrong_or_nobody_learns():
    learner = Residual(mode="online")
    assert make_learner_fault(Scenario(faults=(Push(),), residual=learner)) is None
    assert make_learner_fault(Scenario(faults=(POISON,))) is None  # Its residual is off.
    assert make_learner_fault(Scenario(faults=(Push(), POISON), residual=learner)) is not None

"""Faults of the residual estimator's learning."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.scenario import LearnerDiverged, LearnerFault, LearnerNan, LearnerPoisoned, Scenario


class LearnerFaultSystem(LeafSystem):
    """What goes wrong with the learner, all declared faults together.

    Reference time is the context's time less `settle_s`. A fault acts from its
    start until before its end.

    Ports:
        out `fault` (4): what each number of the last layer is off by at an update, in m/s,
            and then the offset of the velocities that are learned, (3,) m/s. It changes with
            time alone.
    State, rate: none.

    Args:
        faults: Their offsets add up.
        settle_s: s, hover before reference time 0.
    """

    def __init__(self, faults: Sequence[LearnerFault], settle_s: float):
        super().__init__()
        self._faults, self._settle_s = tuple(faults), settle_s
        self.DeclareVectorOutputPort("fault", 4, self._calc_fault, {self.time_ticket()})

    def _calc_fault(self, context: Context, output: BasicVector) -> None:
        now = round(context.get_time() - self._settle_s, 9)  # 0 is 0, whatever rounding did.
        active = [
            _offset(fault) for fault in self._faults if fault.start_s <= now < round(fault.end_s, 9)
        ]
        output.SetFromVector(np.sum(active, axis=0) if active else np.zeros(4))


def make_learner_fault(scenario: Scenario) -> LearnerFaultSystem | None:
    """The system of the scenario's learning faults; None where it has none, or no learner."""
    faults = [fault for fault in scenario.faults if isinstance(fault, LearnerFault)]
    if not faults or scenario.residual.mode == "off":
        return None
    return LearnerFaultSystem(faults, scenario.settle_s)


def _offset(fault: LearnerFault) -> np.ndarray:
    """(4,) as the port has it."""
    match fault:
        case LearnerNan():
            theta, velocity = np.nan, (0.0, 0.0, 0.0)
        case LearnerDiverged():
            theta, velocity = fault.theta_m_s, (0.0, 0.0, 0.0)
        case LearnerPoisoned():
            theta, velocity = 0.0, fault.velocity_m_s
    return np.array([theta, *velocity])

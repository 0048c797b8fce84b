"""Residual estimator with learning faults, in place of the plain one if a scenario has any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydrake.systems.framework import Context, DependencyTicket

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.estimation import EstimatorState, ResidualEstimation
from aerodrake.model.residual.gate import GateCause, GateState, Sample
from aerodrake.model.residual.online_learner import LearnerState
from aerodrake.model.residual.scenario_network import network_for
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import (
    AnyFault,
    LearnerDiverged,
    LearnerFault,
    LearnerNan,
    LearnerPoisoned,
    Residual,
    Scenario,
)
from aerodrake.systems.residual_estimator import ResidualEstimator

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual.network import ResidualNetwork


class LearnerOffset(NamedTuple):
    """Sum of the active learning faults.

    Attributes:
        theta_m_s: m/s, added to each entry of the last layer after its step; NaN possible.
        velocity_m_s: (3,) m/s, added to the measured velocity of labels.
    """

    theta_m_s: float
    velocity_m_s: np.ndarray


@dataclass(frozen=True, eq=False)
class FaultyEstimation(ResidualEstimation):
    """`ResidualEstimation` at a tick with faults; features and state are not affected."""

    offset: LearnerOffset = LearnerOffset(0.0, np.zeros(3))

    def label_motion(self, vehicle: VehicleState) -> tuple[np.ndarray, np.ndarray]:
        """Returns p_B and the velocity with its offset."""
        p_B, v_B = super().label_motion(vehicle)
        return p_B, v_B + self.offset.velocity_m_s

    def learn(
        self, state: EstimatorState, sample: Sample | None, is_saturated: bool
    ) -> tuple[LearnerState, GateState, GateCause]:
        """Learns, then adds the offset to the last layer."""
        learner, gate, cause = super().learn(state, sample, is_saturated)
        theta = learner.theta + self.offset.theta_m_s
        return learner._replace(theta=theta), gate, cause


class FaultyResidualEstimator(ResidualEstimator):
    """`ResidualEstimator` with learning faults.

    Reference time is the context's time minus `settle_s`. A fault is active from its
    start until before its end.

    Ports:
        those of `ResidualEstimator`.

    State, rate: those of `ResidualEstimator`.

    Args:
        network, model, config: Of `ResidualEstimator`.
        faults: All faults of a scenario; the offsets of its learning faults add up.
        settle_s: s, hover before reference time 0.
    """

    def __init__(
        self,
        network: ResidualNetwork,
        model: EquivalentModel,
        config: Residual,
        faults: Sequence[AnyFault],
        settle_s: float,
    ):
        super().__init__(network, model, config)
        self._faulty = FaultyEstimation(**vars(self._estimation))
        self._faults = [fault for fault in faults if isinstance(fault, LearnerFault)]
        self._settle_s = settle_s

    def _tickets(self) -> set[DependencyTicket]:
        return super()._tickets() | {self.time_ticket()}

    def _equations(self, context: Context) -> ResidualEstimation:
        offset = offset_at(self._faults, context.get_time() - self._settle_s)
        return replace(self._faulty, offset=offset)


def make_residual_estimator(scenario: Scenario, model: EquivalentModel) -> ResidualEstimator:
    """Returns the scenario's residual estimator: a faulty one if it has learning faults.

    Raises:
        ScenarioError: if the scenario's checkpoint cannot be used.
    """
    network = network_for(scenario, model.joints)
    has_faults = any(isinstance(fault, LearnerFault) for fault in scenario.faults)
    if network is None or not has_faults:
        return ResidualEstimator(network, model, scenario.residual)
    return FaultyResidualEstimator(
        network, model, scenario.residual, scenario.faults, scenario.settle_s
    )


def offset_at(faults: Sequence[LearnerFault], reference_s: float) -> LearnerOffset:
    """Returns the sum of the offsets of the faults that are active at a reference time in s."""
    now = round(reference_s, 9)  # Removes rounding errors of multiples of the period.
    theta, velocity = 0.0, np.zeros(3)
    for fault in faults:
        if fault.is_active(now):
            match fault:
                case LearnerNan():
                    theta += np.nan
                case LearnerDiverged():
                    theta += fault.theta_m_s
                case LearnerPoisoned():
                    velocity += fault.velocity_m_s
    return LearnerOffset(theta, velocity)

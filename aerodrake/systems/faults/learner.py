"""Residual estimator with learning faults, in place of the plain one if a scenario has any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.systems.framework import Context, DependencyTicket

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.delta_blend import PerLayer
from aerodrake.model.residual.estimation import EstimatorState, ResidualEstimation
from aerodrake.model.residual.gate import GateState, VelocitySample
from aerodrake.model.residual.layer_gate import GateCause
from aerodrake.model.residual.online_learner import LearnerState
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import (
    AnyFault,
    LearnerDiverged,
    LearnerFault,
    LearnerNan,
    LearnerPoisoned,
    Residual,
)
from aerodrake.support.arguments import Duration, checked
from aerodrake.systems.residual_estimator import ResidualEstimator

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual.network import ResidualNetwork


@dataclass(frozen=True, eq=False)
class FaultyEstimation(ResidualEstimation):
    """`ResidualEstimation` with the sum of the active faults; features are not affected.

    Attributes:
        theta_offset: m/s, added to each entry of the last layer after its step; NaN possible.
        velocity_offset: (3,) m/s, added to the measured velocity of labels.
    """

    theta_offset: float
    velocity_offset: np.ndarray

    def label_velocity(self, vehicle: VehicleState) -> np.ndarray:
        """Returns the measured v_B with its offset, (3,) m/s."""
        return super().label_velocity(vehicle) + self.velocity_offset

    def learn(
        self, state: EstimatorState, sample: VelocitySample | None, is_saturated: bool
    ) -> tuple[LearnerState, GateState, PerLayer[GateCause]]:
        """Learns, then adds the offset to the last layer."""
        learner, gate, causes = super().learn(state, sample, is_saturated)
        return learner._replace(theta=learner.theta + self.theta_offset), gate, causes


class FaultyResidualEstimator(ResidualEstimator):
    """`ResidualEstimator` with learning faults, each active from its start until before its end.

    Ports:
        those of `ResidualEstimator`.
    State:
        discrete groups of `LearnerState`, `PendingPrediction`, `PredictionErrors` and `GateState`,
        as of `ResidualEstimator`.
    Rate:
        the period of the model, from time 0.

    Args:
        network, model, config: As for `ResidualEstimator`.
        faults: All faults of a scenario; the offsets of its learning faults add up.
        settle_s: s, hover before reference time 0.
    """

    @checked
    def __init__(
        self,
        network: ResidualNetwork,
        model: EquivalentModel,
        config: Residual,
        faults: Sequence[AnyFault],
        settle_s: Duration,
    ):
        super().__init__(network, model, config)
        self._faults = [fault for fault in faults if isinstance(fault, LearnerFault)]
        self._settle_s = settle_s

    def _tickets(self) -> set[DependencyTicket]:
        return super()._tickets() | {self.time_ticket()}

    def _equations(self, context: Context) -> ResidualEstimation:
        offsets = offsets_at(self._faults, context.get_time() - self._settle_s)
        return FaultyEstimation(**vars(self._estimation), **offsets)


@checked
def make_residual_estimator(
    network: ResidualNetwork | None,
    model: EquivalentModel,
    config: Residual,
    faults: Sequence[AnyFault],
    settle_s: Duration,
) -> ResidualEstimator:
    """Returns a scenario's residual estimator: a faulty one if it has learning faults."""
    if network is None or not any(isinstance(fault, LearnerFault) for fault in faults):
        return ResidualEstimator(network, model, config)
    return FaultyResidualEstimator(network, model, config, faults, settle_s)


def offsets_at(faults: Sequence[LearnerFault], reference_s: float) -> dict[str, Any]:
    """Returns the sums of the active faults' offsets at a reference time in s, by their names."""
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
    return {"theta_offset": theta, "velocity_offset": velocity}

"""Sensor of the tool's position as a system."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import TOOL
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import ToolSensor
from aerodrake.support.arguments import Duration, StateVector, checked
from aerodrake.systems.named_state import NamedState


class ToolSample(NamedTuple):
    """Sample of the tool's position: position (3,) m in the world, and its time stamp in s, minus
    infinity before the first."""

    position: np.ndarray
    stamp: float


class ToolSensorSystem(LeafSystem):
    """Measures the tool's position in the world while it is seen.

    Ports:
        in `state` (13 + 2 n): true state that a sample contains.
        in `noise` (3): standard normal draws, new at each sample.
        in `draws` (10): uniform, for latency and loss.
        out `tool_position` (3): m in the world, the last sample; before the first, the tool's
            position in trim.
        out `tool_stamp` (1): s, its time stamp.
    State:
        `position` (3) and `stamp` (1).
    Rate:
        `config.period_s`, after `offset`.

    Args:
        config: Noise, mounting and visibility.
        delivery: Latency and loss.
        plant: The robot's nominal plant.
        offset: s, time of the first sample.
        initial: (13 + 2 n,) the state before the first sample.
    """

    @checked
    def __init__(
        self,
        config: ToolSensor,
        delivery: Delivery,
        plant: MultibodyPlant,
        offset: Duration,
        initial: StateVector,
    ):
        super().__init__()
        self._config, self._delivery = config, delivery
        self._mounting, self._kinematics = np.array(config.mounting_m), Kinematics(plant)
        self._least_down = np.cos(config.visible_rad) - 1e-9  # Tolerates rounding.
        self._state = self.DeclareVectorInputPort("state", len(initial))
        self._noise = self.DeclareVectorInputPort("noise", 3)
        self._draws = self.DeclareVectorInputPort("draws", DRAWS)
        position, _ = self._measured(split_state(initial))
        self._last = NamedState(self, ToolSample(position, -np.inf))
        self.DeclareStateOutputPort("tool_position", self._last.groups["position"])
        self.DeclareStateOutputPort("tool_stamp", self._last.groups["stamp"])
        self.DeclarePeriodicDiscreteUpdateEvent(config.period_s, offset, self._sample)

    def _measured(self, state: VehicleState) -> tuple[np.ndarray, bool]:
        """Returns the position (3,) m without noise, and True if the tool is seen."""
        X_BE = self._kinematics.tool_pose(state.q)
        R_E = state.R_B @ X_BE.rotation().matrix()
        position = state.p_B + state.R_B @ X_BE.translation() + R_E @ self._mounting
        return position, R_E[2, 2] >= self._least_down  # The tool's axis is -z of its frame.

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        draws, last = self._draws.Eval(context), self._last.read(context)
        stamp = self._delivery.stamp(TOOL, context.get_time(), draws)
        position, is_visible = self._measured(split_state(self._state.Eval(context)))
        is_lost = self._delivery.is_lost(TOOL, draws)
        if is_visible and stamp > last.stamp and not is_lost:
            position = position + self._config.noise_m * self._noise.Eval(context)
            self._last.write(discrete, ToolSample(position, stamp))

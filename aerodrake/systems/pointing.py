"""The orientation task as a system: where the tool points, and where it is to."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, LeafSystem

from aerodrake.model.mpc.inputs import Pointing
from aerodrake.model.reference.direction import Direction, check_start
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel


class PointingSystem(LeafSystem):
    """The tool's axis at the measured state, and its wanted direction over the horizon.

    Reference time is the context's time less `settle_s`.

    Ports:
        in `state` (13 + 2 n): measured state.
        out `pointing` (abstract): `Pointing`.
    State, rate:
        none; a function of state and time.

    Args:
        vehicle: The robot, and where its tool points at first.
        direction: Over reference time.
        settle_s: s, hover before reference time 0.
        stages_s: (N + 1,) s, from now to each stage, 0 first.

    Raises:
        BadInput: as `check_start` does.
    """

    def __init__(
        self, vehicle: VehicleModel, direction: Direction, settle_s: float, stages_s: np.ndarray
    ):
        super().__init__()
        check_start(direction, vehicle)
        self._kinematics, self._direction = Kinematics(vehicle.robot), direction
        self._settle_s, self._stages = settle_s, stages_s
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self.DeclareAbstractOutputPort(
            "pointing",
            lambda: Value(object()),
            self._calc_pointing,
            {self.all_input_ports_ticket(), self.time_ticket()},
        )

    def _calc_pointing(self, context: Context, output: AbstractValue) -> None:
        state = split_state(self._state.Eval(context))
        times = context.get_time() - self._settle_s + self._stages
        output.set_value(
            Pointing(self._kinematics.tool_axis(state), np.hstack(self._direction.evaluate(times)))
        )

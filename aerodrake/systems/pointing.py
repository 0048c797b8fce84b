"""The orientation task as a system."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.mpc.tick import Pointing
from aerodrake.model.reference.direction import Direction, check_start
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.arguments import Duration, Vector, checked


class PointingSystem(LeafSystem):
    """Measured direction of the tool's axis, and its desired direction over the horizon.

    Directions are unit vectors in the world frame. Reference time is the context's time minus
    `settle_s`, rounded to 1 ns.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        out `pointing` (abstract): `Pointing`, input of the MPC.
        out `tool_axis_horizon` (6 (N + 1)): desired direction d of the tool's axis and d' in 1/s,
            now and at each stage of the horizon; row-major (N + 1, 6).
        out `tool_axis_d` (3): d, now.
    State, rate:
        none; a function of state and time.

    Args:
        vehicle: The robot and its working configuration.
        direction: Desired direction over reference time.
        settle_s: s, hover before reference time 0.
        stages_s: (N + 1,) s, from now to each stage, 0 first.

    Raises:
        BadInput: as `check_start` does.
    """

    @checked
    def __init__(
        self, vehicle: VehicleModel, direction: Direction, settle_s: Duration, stages_s: Vector
    ):
        super().__init__()
        check_start(direction, vehicle)
        self._kinematics, self._direction = Kinematics(vehicle.plant), direction
        self._settle_s, self._stages = settle_s, stages_s
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        time = {self.time_ticket()}
        self._horizon = self.DeclareVectorOutputPort(
            "tool_axis_horizon", 6 * len(stages_s), self._calc_horizon, time
        )
        self.DeclareVectorOutputPort("tool_axis_d", 3, self._calc_tool_axis_d, time)
        self.DeclareAbstractOutputPort(
            "pointing",
            lambda: Value(object()),
            self._calc_pointing,
            {self.all_input_ports_ticket(), self.time_ticket()},
        )

    def _calc_pointing(self, context: Context, output: AbstractValue) -> None:
        state = split_state(self._state.Eval(context))
        horizon = self._horizon.Eval(context).reshape(-1, 6)
        output.set_value(Pointing(self._kinematics.tool_axis(state), horizon))

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        now = round(context.get_time() - self._settle_s, 9)  # 0 is exactly 0.
        output.SetFromVector(np.hstack(self._direction.evaluate(now + self._stages)).ravel())

    def _calc_tool_axis_d(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._horizon.Eval(context)[:3])

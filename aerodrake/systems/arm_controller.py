"""Arm controller: the joints' low-level controller."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.low_level.joint_pid import JointPid, control
from aerodrake.model.vehicle.arm_inertia import ArmInertia
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Arm
from aerodrake.support.arguments import Duration, Period, checked
from aerodrake.systems.named_state import NamedState


class ArmState(NamedTuple):
    """State of the arm controller.

    Attributes:
        integral, joint_torque: (n,) N m.
    """

    integral: np.ndarray
    joint_torque: np.ndarray


class ArmController(LeafSystem):
    """Discrete PID controller of the joints.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2; q_d'' is
            ignored.
        out `joint_torque` (n): N m, constant between ticks.
        out `torque_at_limit` (n): 1 for each joint whose torque is at its limit.
    State:
        `integral` (n) N m, `joint_torque` (n) N m.
    Rate:
        `period`, after `offset`, so that it uses the MPC's command of the same instant.

    Accelerations become torques through the arm's inertia matrix at the measured angles. With
    `inertia` diagonal, it is the diagonal of the matrix in the working configuration.

    Args:
        config: Gains.
        vehicle: Inertia, damping, limits and trim.
        period: s.
        offset: s, time of the first update.
    """

    @checked
    def __init__(self, config: Arm, vehicle: VehicleModel, period: Period, offset: Duration):
        super().__init__()
        self._pid = JointPid.make(config, vehicle, period)
        self._inertia = ArmInertia(vehicle.plant) if config.inertia == "coupled" else None
        n = vehicle.joints
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._last = NamedState(self, ArmState(vehicle.trim_torque, vehicle.trim_torque))
        self._torque = self._last.groups["joint_torque"]
        self.DeclareStateOutputPort("joint_torque", self._torque)
        self.DeclareVectorOutputPort(
            "torque_at_limit",
            n,
            self._calc_at_limit,
            {self.discrete_state_ticket(self._torque)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _calc_at_limit(self, context: Context, output: BasicVector) -> None:
        torque = context.get_discrete_state(self._torque).value()
        output.SetFromVector(np.abs(torque) >= self._pid.effort)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        pid, state = self._pid, self._state.Eval(context)
        if self._inertia is not None:
            pid = pid._replace(inertia=self._inertia.at(split_state(state).q))
        torque, integral = control(
            pid, state, self._setpoint.Eval(context), self._last.read(context).integral
        )
        self._last.write(discrete, ArmState(integral, torque))

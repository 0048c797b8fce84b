"""Friction of the joints as a system between motors and plant."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.actuation.joint_friction import JointFriction, deflection, friction_torque
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.arguments import Period, checked
from aerodrake.systems.named_state import NamedState


class FrictionState(NamedTuple):
    """State of the joints' friction.

    Attributes:
        deflection: (n,) rad, elastic deflection of each joint before it slides.
    """

    deflection: np.ndarray


class JointFrictionSystem(LeafSystem):
    """Adds the torque of friction to those of the motors.

    The plant may be of any engine: it holds the torque for a step.

    Ports:
        in `motor_torque` (n): N m.
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        out `joint_torque` (n): N m, of motors and friction; it feeds through.
    State:
        `deflection` (n) rad, zero at first.
    Rate:
        `period`, that of the plant, by a discrete update.

    Args:
        config: Coulomb and viscous friction.
        vehicle: Inertia of the arm.
        period: s.
    """

    @checked
    def __init__(self, config: Actuation, vehicle: VehicleModel, period: Period):
        super().__init__()
        self._friction = JointFriction.make(config, vehicle, period)
        n = vehicle.joints
        self._motor_torque = self.DeclareVectorInputPort("motor_torque", n)
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(n))
        self._last = NamedState(self, FrictionState(np.zeros(n)))
        ports = self._motor_torque, self._true_state
        self.DeclareVectorOutputPort(
            "joint_torque",
            n,
            self._calc_torque,
            {self.xd_ticket(), *(port.ticket() for port in ports)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        qdot = split_state(self._true_state.Eval(context)).qdot
        torque = friction_torque(self._friction, self._last.read(context).deflection, qdot)
        output.set_value(self._motor_torque.Eval(context) + torque)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        qdot = split_state(self._true_state.Eval(context)).qdot
        last = self._last.read(context).deflection
        self._last.write(discrete, FrictionState(deflection(self._friction, last, qdot)))


@checked
def make_joint_friction(
    config: Actuation, vehicle: VehicleModel, period: Period
) -> JointFrictionSystem | None:
    """Makes the friction of a scenario's joints; None if there is none."""
    if not any((*config.coulomb_n_m, *config.viscous_n_m_s_rad)):
        return None
    return JointFrictionSystem(config, vehicle, period)

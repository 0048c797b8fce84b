"""Backlash and flexibility of the joints as a system between motors and links."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.actuation.joint_transmission import JointTransmission, transmitted, twist
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.arguments import Period, checked
from aerodrake.systems.named_state import NamedState


class TransmissionState(NamedTuple):
    """State of the transmissions.

    Attributes:
        twist: (n,) rad, angle of each motor relative to its link.
    """

    twist: np.ndarray


class JointTransmissionSystem(LeafSystem):
    """Passes the torques of the motors to the links through gaps and springs.

    Ports:
        in `motor_torque` (n): N m.
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        out `joint_torque` (n): N m, on the links until the next step; it feeds through.
        out `encoder_state` (13 + 2 n): the true state with angles and rates of the motors, which
            encoders measure: those of the links plus the twist, and its mean rate in this step.
    State:
        `twist` (n) rad, at first that of trim.
    Rate:
        `period`, that of the plant, by a discrete update.

    Args:
        config: Backlash and flexibility.
        vehicle: Limits and trim of the joints.
        period: s.
    """

    @checked
    def __init__(self, config: Actuation, vehicle: VehicleModel, period: Period):
        super().__init__()
        self._transmission = JointTransmission.make(config, vehicle, period)
        n = vehicle.joints
        self._motor_torque = self.DeclareVectorInputPort("motor_torque", n)
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(n))
        initial = self._transmission.at_rest(vehicle.trim_torque)
        self._last = NamedState(self, TransmissionState(initial))
        tickets = {self.xd_ticket(), self._motor_torque.ticket()}
        self.DeclareVectorOutputPort("joint_torque", n, self._calc_torque, tickets)
        self.DeclareVectorOutputPort(
            "encoder_state",
            VehicleState.size(n),
            self._calc_encoder_state,
            {*tickets, self._true_state.ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        last, torque = self._last.read(context).twist, self._motor_torque.Eval(context)
        output.set_value(transmitted(self._transmission, last, torque))

    def _calc_encoder_state(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._true_state.Eval(context))
        last = self._last.read(context).twist
        turned = twist(self._transmission, last, self._motor_torque.Eval(context)) - last
        measured = split_state(output.get_mutable_value())
        measured.q[:] += last
        measured.qdot[:] += turned / self._transmission.dt

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last, torque = self._last.read(context).twist, self._motor_torque.Eval(context)
        self._last.write(discrete, TransmissionState(twist(self._transmission, last, torque)))


@checked
def make_joint_transmission(
    config: Actuation, vehicle: VehicleModel, period: Period
) -> JointTransmissionSystem | None:
    """Makes the transmissions of a scenario's joints; None if they are rigid and without gap."""
    if not any((*config.backlash_rad, *config.flexibility_rad_n_m)):
        return None
    return JointTransmissionSystem(config, vehicle, period)

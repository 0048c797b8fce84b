"""Backlash and flexibility of the joints as a system between motors and links."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.actuation.joint_transmission import JointTransmission, Turn, load, turn
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.arguments import Period, checked
from aerodrake.systems.named_state import NamedState


class TransmissionState(NamedTuple):
    """State of the transmissions.

    Attributes:
        twist: (n,) rad, angle of each motor relative to its link.
        qdot: (n,) rad/s, rates of the links one step ago.
    """

    twist: np.ndarray
    qdot: np.ndarray


class JointTransmissionSystem(LeafSystem):
    """Passes the torques of the motors to the links through gaps and springs.

    Ports:
        in `motor_torque` (n): N m.
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        out `joint_torque` (n): N m, on the links until the next step; it feeds through.
        out `encoder_state` (13 + 2 n): the true state with the angles of the motors, which encoders
            measure: those of the links plus the twist. The rates are the links'.
    State:
        `twist` (n) rad, at first that of trim; `qdot` (n) rad/s, rates of the links one step ago.
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
        self._last = NamedState(self, TransmissionState(initial, np.zeros(n)))
        self.DeclareVectorOutputPort("joint_torque", n, self._calc_torque)
        self.DeclareVectorOutputPort(
            "encoder_state",
            VehicleState.size(n),
            self._calc_encoder_state,
            {self.xd_ticket(), self._true_state.ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _turn(self, context: Context) -> Turn:
        """Returns the motion in this step."""
        last, torque = self._last.read(context), self._motor_torque.Eval(context)
        change = split_state(self._true_state.Eval(context)).qdot - last.qdot
        return turn(self._transmission, last.twist, load(self._transmission, torque, change))

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._turn(context).contact * self._motor_torque.Eval(context))

    def _calc_encoder_state(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._true_state.Eval(context))
        angles = split_state(output.get_mutable_value()).q
        angles += self._last.read(context).twist

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        qdot = split_state(self._true_state.Eval(context)).qdot
        self._last.write(discrete, TransmissionState(self._turn(context).twist, qdot))


def is_rigid(config: Actuation) -> bool:
    """Returns True if motors and links have the same angles."""
    return not any((*config.backlash_rad, *config.flexibility_rad_n_m))


@checked
def make_joint_transmission(
    config: Actuation, vehicle: VehicleModel, period: Period
) -> JointTransmissionSystem | None:
    """Makes the transmissions of a scenario's joints; None if they are rigid and without gap."""
    if is_rigid(config):
        return None
    return JointTransmissionSystem(config, vehicle, period)

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
        out `encoder_state` (13 + 2 n): the true state with the angles of the motors, which encoders
            measure: those of the links plus the twist. The rates are the links', since that of a
            motor without inertia would jump with its torque.
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
        self.DeclareVectorOutputPort(
            "joint_torque",
            n,
            self._calc_torque,
            {self.xd_ticket(), self._motor_torque.ticket()},
        )
        self.DeclareVectorOutputPort(
            "encoder_state",
            VehicleState.size(n),
            self._calc_encoder_state,
            {self.xd_ticket(), self._true_state.ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        last, torque = self._last.read(context).twist, self._motor_torque.Eval(context)
        output.set_value(transmitted(self._transmission, last, torque))

    def _calc_encoder_state(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._true_state.Eval(context))
        angles = split_state(output.get_mutable_value()).q
        angles += self._last.read(context).twist

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last, torque = self._last.read(context).twist, self._motor_torque.Eval(context)
        self._last.write(discrete, TransmissionState(twist(self._transmission, last, torque)))


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

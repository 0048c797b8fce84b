"""Kinematics of the end-effector, d_e and d_o as a system, evaluated once for all consumers."""

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.vehicle.kinematics import EndEffector, Kinematics
from aerodrake.model.vehicle.rotation import length
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.support.arguments import Count, Vector3, checked


class KinematicsSystem(LeafSystem):
    """Kinematics of the end-effector, and its distances from the target and the learning space.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `reference` (6): p_Ed, p_Ed' in m, m/s.
        out `end_effector` (abstract): `EndEffector`.
        out `distances` (2): distances in m of the end-effector: d_e from the current target
            point p_Ed(t), and d_o from the centre of the learning space. The paper's d_e is the
            distance to the target trajectory; a distance to the nearest point of its path would
            be zero on the path, however far behind the target.
    State, rate:
        none; cached until `state` or `reference` changes.

    Args:
        kinematics: Kinematics of the robot.
        joints: Number n of joints.
        p_O: (3,) m, centre of the learning space in the base frame.
    """

    @checked
    def __init__(self, kinematics: Kinematics, joints: Count, p_O: Vector3):
        super().__init__()
        self._kinematics = kinematics
        self._p_O = p_O
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(joints))
        self._reference = self.DeclareVectorInputPort("reference", 6)
        state_only = {self.input_port_ticket(self._state.get_index())}
        self._end_effector = self.DeclareAbstractOutputPort(
            "end_effector", lambda: Value(object()), self._calc_end_effector, state_only
        )
        self.DeclareVectorOutputPort(
            "distances", 2, self._calc_distances, {self.all_input_ports_ticket()}
        )

    def _calc_end_effector(self, context: Context, output: AbstractValue) -> None:
        state = split_state(self._state.Eval(context))
        output.set_value(self._kinematics.end_effector(state))

    def _calc_distances(self, context: Context, output: BasicVector) -> None:
        end_effector: EndEffector = self._end_effector.Eval(context)
        p_Ed = self._reference.Eval(context)[:3]
        output.SetFromVector(
            [length(end_effector.p_E - p_Ed), length(end_effector.p_EB - self._p_O)]
        )

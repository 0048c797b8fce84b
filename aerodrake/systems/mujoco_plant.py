"""Plant in MuJoCo."""

from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.mujoco.engine import MujocoEngine
from aerodrake.model.vehicle.state import split_state
from aerodrake.support.arguments import Period, StateVector, checked


class MujocoPlant(LeafSystem):
    """Vehicle, payload and ground in MuJoCo, a plant with the ports of Drake's.

    Ports:
        in `thrust` (k): N, of the rotors.
        in `joint_torque` (n): N m.
        in `generalized_force` (6 + n): on the velocities [omega_W, v_B, q'].
        out `state` (13 + 2 n): `VehicleState`.
        out `body_poses` (abstract): pose of each body in the world.
    State:
        the `VehicleState` (13 + 2 n), and nothing else, so that Contexts can be copied.
    Rate:
        `period`, by a discrete update with the inputs of its instant.

    Attributes:
        engine: The vehicle's dynamics.

    Args:
        engine: The vehicle's dynamics, whose step is `period`.
        bodies: Numbers in MuJoCo of the bodies in `body_poses`.
        trim_state: (13 + 2 n,) state of the default Context.
        period: s.
    """

    @checked
    def __init__(
        self, engine: MujocoEngine, bodies: list[int], trim_state: StateVector, period: Period
    ):
        super().__init__()
        self.engine, self._bodies = engine, bodies
        joints = len(split_state(trim_state).q)
        self._thrust = self.DeclareVectorInputPort("thrust", engine.model.nu)
        self._joint_torque = self.DeclareVectorInputPort("joint_torque", joints)
        self._force = self.DeclareVectorInputPort("generalized_force", engine.model.nv)
        state = self.DeclareDiscreteState(trim_state)
        self.DeclareStateOutputPort("state", state)
        self.DeclareAbstractOutputPort(
            "body_poses",
            Value[list[RigidTransform]],
            self._calc_body_poses,
            {self.discrete_state_ticket(state)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        inputs = (port.Eval(context) for port in (self._thrust, self._joint_torque, self._force))
        discrete.set_value(self.engine.step(context.get_discrete_state_vector().value(), *inputs))

    def _calc_body_poses(self, context: Context, output: AbstractValue) -> None:
        x = context.get_discrete_state_vector().value()
        output.set_value(self.engine.body_poses(x, self._bodies))

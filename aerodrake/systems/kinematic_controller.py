"""What the MPC and its alternatives have in common as systems."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.inputs import MpcInputs
from aerodrake.model.qp.condensed_qp import QpStatus, is_answer
from aerodrake.model.vehicle.state import VehicleState, split_state


class KinematicController(LeafSystem):
    """From measurement, reference and weights to accelerations of the setpoints.

    A subclass says in `_update` what is commanded, and hands it to `_command`.

    Ports:
        in `state` (13 + 2 n): measured state.
        in `x_0` (nx): state of the equivalent model.
        in `end_effector` (abstract): `EndEffector` at that state.
        in `base_setpoint` (9), `joint_setpoint` (3 n): what is commanded now.
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' now and at each stage.
        in `weights` (5): gamma, mode, w_q, w_m, w_d.
        in `delta` (3): m/s, residual velocity.
        out `u` (3 + n): m/s^2 and rad/s^2, accelerations of the setpoints.
        out `prediction` (3 (N + 1)): m, p_E now and as predicted at each stage.
        out `status` (3): a `QpStatus`, the solver's iterations, and how many ticks ago the
            last answer was.
        out `weights` (5), `delta` (3): those that the last tick was given.
        out `plan` (P (3 + n)): u at the last tick, and as it is to be at those after it, as far
            as that is known. A subclass declares it.
    State:
        `u`, `prediction`, `status`, `weights` and `delta`, of the last tick.
    Rate:
        the equivalent model's period.

    Attributes:
        tick_ms: Wall time of the computation at each tick so far. An instrument
            beside the Context: it never feeds back.

    Args:
        model: The equivalent model.
        horizon: N.
    """

    def __init__(self, model: EquivalentModel, horizon: int):
        super().__init__()
        self.tick_ms: list[float] = []
        N, n = horizon, model.joints
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._x_0 = self.DeclareVectorInputPort("x_0", len(model.A))
        self._end_effector = self.DeclareAbstractInputPort(
            "end_effector", AbstractValue.Make(object())
        )
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._horizon = self.DeclareVectorInputPort("horizon", 6 * (N + 1))
        self._weights = self.DeclareVectorInputPort("weights", 5)
        self._delta = self.DeclareVectorInputPort("delta", 3)
        self._x_u = self.DeclareDiscreteState(np.zeros(3 + n))
        self._x_prediction = self.DeclareDiscreteState(np.zeros(3 * (N + 1)))
        self._x_status = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("u", self._x_u)
        self.DeclareStateOutputPort("prediction", self._x_prediction)
        self.DeclareStateOutputPort("status", self._x_status)
        self._x_weights = self.DeclareDiscreteState(np.zeros(5))
        self._x_delta = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("weights", self._x_weights)
        self.DeclareStateOutputPort("delta", self._x_delta)
        self.DeclarePeriodicDiscreteUpdateEvent(model.dt, 0.0, self._update)

    def tick_inputs(self, context: Context) -> MpcInputs:
        """What the tick at this Context is about."""
        state = split_state(self._state.Eval(context))
        _, _, a_d = self._base_setpoint.Eval(context).reshape(3, -1)
        _, _, qddot_d = self._joint_setpoint.Eval(context).reshape(3, -1)
        _, _, w_q, w_m, w_d = self._weights.Eval(context)
        return MpcInputs(
            x_0=self._x_0.Eval(context),
            u_last=np.concatenate([a_d, qddot_d]),
            end_effector=self._end_effector.Eval(context),
            rpy_rates=state.rpy_rates,
            reference=self._horizon.Eval(context).reshape(-1, 6),
            delta=self._delta.Eval(context),
            w_q=w_q,
            w_m=w_m,
            w_d=w_d,
        )

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        raise NotImplementedError

    def _command(
        self,
        context: Context,
        discrete: DiscreteValues,
        u: np.ndarray,
        prediction: np.ndarray,
        status: QpStatus,
        iterations: int,
    ) -> None:
        """Sets what the outputs show until the next tick."""
        age = context.get_discrete_state(self._x_status).value()[2]
        age = 0 if is_answer(status) else age + 1
        # What a tick without inputs believes is nothing that others are to see.
        if not np.isfinite(prediction).all():
            prediction = context.get_discrete_state(self._x_prediction).value()
        discrete.set_value(self._x_u, u)
        discrete.set_value(self._x_prediction, prediction.ravel())
        discrete.set_value(self._x_status, (status, iterations, age))
        discrete.set_value(self._x_weights, self._weights.Eval(context))
        discrete.set_value(self._x_delta, self._delta.Eval(context))

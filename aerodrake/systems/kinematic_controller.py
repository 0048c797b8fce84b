"""Base class of the MPC and CLIK systems."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.tick import MpcInputs, TickStatus
from aerodrake.model.mpc.weight_allocation import AllocatedWeights
from aerodrake.model.qp.result import is_solved
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.support.arguments import Count, Timed, checked
from aerodrake.systems.named_state import NamedState


class ControllerState(NamedTuple):
    """Outputs u, prediction, status, weights, delta of a tick, as in `KinematicController`."""

    u: np.ndarray
    prediction: np.ndarray
    status: np.ndarray
    weights: np.ndarray
    delta: np.ndarray


class KinematicController(LeafSystem):
    """Computes accelerations of the setpoints from measurement, reference and weights.

    A subclass implements `solve_tick` and `_apply`, and declares the port `plan`; `ClikSystem` is
    an example. A new baseline flies as a replacement of `mpc` (`aerodrake.wiring.replacements`),
    with `plan` and an input `pointing` as `MpcSystem` has them. To add it to the package, extend
    `Scenario.controller`, `make_controller` in `aerodrake.coordinator`, and `RATES` in
    `aerodrake.station`.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `x_0` (nx): state of the equivalent model.
        in `end_effector` (abstract): `EndEffector` at the measured state.
        in `base_setpoint` (9): current p_d, v_d, a_d in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): current q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' in m, m/s, now and at each stage.
        in `weights` (5): `AllocatedWeights`: gamma, the mode, and w_q, w_m, w_d.
        in `delta` (3): residual of the model: a velocity in m/s in the models with K_B alone, an
            acceleration in m/s^2 in the flight model.
        out `u` (3 + n): m/s^2 and rad/s^2, accelerations of the setpoints.
        out `prediction` (3 (N + 1)): m, p_E now and predicted at each stage.
        out `status` (3): `TickStatus`: result, iterations, and ticks since the last solution.
        out `weights` (5): the input `weights` at the last tick.
        out `delta` (3): the input `delta` at the last tick.
        out `plan` (P (3 + n)): m/s^2 and rad/s^2, u at the last tick and at the next ticks, as far
            as it is planned.
    State:
        `u`, `prediction`, `status`, `weights` and `delta`, of the last tick.
    Rate:
        period of the equivalent model, `rates.mpc_period_s` of a scenario.

    Args:
        model: The equivalent model.
        horizon: N.
    """

    @checked
    def __init__(self, model: Annotated[EquivalentModel, Timed("dt")], horizon: Count):
        super().__init__()
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
        self._last = NamedState(
            self,
            ControllerState(
                u=np.zeros(3 + n),
                prediction=np.zeros((N + 1, 3)),
                status=np.zeros(3),
                weights=np.zeros(5),
                delta=np.zeros(3),
            ),
        )
        for name, group in self._last.groups.items():
            self.DeclareStateOutputPort(name, group)
        self.DeclarePeriodicDiscreteUpdateEvent(model.dt, 0.0, self._update)

    def tick_inputs(self, context: Context) -> MpcInputs:
        """Returns the inputs of the tick at this Context."""
        state = split_state(self._state.Eval(context))
        _, _, a_d = self._base_setpoint.Eval(context).reshape(3, -1)
        _, _, qddot_d = self._joint_setpoint.Eval(context).reshape(3, -1)
        weights = AllocatedWeights(*self._weights.Eval(context))
        return MpcInputs(
            x_0=self._x_0.Eval(context),
            u_last=np.concatenate([a_d, qddot_d]),
            end_effector=self._end_effector.Eval(context),
            rpy_rates=state.rpy_rates,
            reference=self._horizon.Eval(context).reshape(-1, 6),
            delta=self._delta.Eval(context),
            w_q=weights.w_q,
            w_m=weights.w_m,
            w_d=weights.w_d,
        )

    def solve_tick(self, context: Context, tick: MpcInputs) -> Any:
        """Forms and solves the problem of one tick. `time_ticks` measures its wall time."""
        raise NotImplementedError

    def _apply(
        self, context: Context, discrete: DiscreteValues, tick: MpcInputs, solution: Any
    ) -> None:
        """Updates the state with a solution of `solve_tick`."""
        raise NotImplementedError

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tick = self.tick_inputs(context)
        self._apply(context, discrete, tick, self.solve_tick(context, tick))

    def _set_outputs(
        self,
        context: Context,
        discrete: DiscreteValues,
        u: np.ndarray,
        prediction: np.ndarray,
        status: int,
        iterations: int,
    ) -> None:
        """Sets the outputs until the next tick; a prediction that is not finite is discarded."""
        last = self._last.read(context)
        age = 0 if is_solved(status) else TickStatus(*last.status).ticks_since_solved + 1
        state = ControllerState(
            u=u,
            prediction=prediction if np.isfinite(prediction).all() else last.prediction,
            status=np.array(TickStatus(status, iterations, age)),
            weights=self._weights.Eval(context),
            delta=self._delta.Eval(context),
        )
        self._last.write(discrete, state)

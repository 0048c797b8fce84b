"""Cost and bounds of the MPC as a condensed quadratic program (paper, section III-A, B)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.condensing import Condensing, gradient, hessian, outputs_under
from aerodrake.model.mpc.horizon import StageOutputs, StageStates, stage_ticks
from aerodrake.model.mpc.stage_cost import (
    TrackingTask,
    add_tracking,
    limited_gain,
    posture_cost,
    predict_task,
)
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.quadratic_program import QuadraticProgram
from aerodrake.model.setpoint.integration import SetpointLimits, braking
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc

SLACK = 1e-6
"""Margin of relaxed bounds around full braking, in scaled rows."""


@dataclass(frozen=True)
class MpcProgram:
    """min z^T H z / 2 + g^T z with |z| <= 1 and lower <= A z <= upper.

    z (m N,) stacks the scaled inputs axis by axis, the stages of the first axis first.

    Attributes:
        g: (m N,).
        A: (rows, m N), rows of unit norm.
        lower, upper: (rows,).
        free_response: (F, N), outputs of the stages with zero inputs.
        C: (F, F), quadratic cost of the outputs of a stage.
        task_jacobian: (k, n), motion of all task vectors per joint motion.
        condensing: Constant part of the program, which turns C into H.
        v_d: (m,) m/s and rad/s, current velocities of the setpoints.
    """

    g: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    free_response: np.ndarray
    C: np.ndarray
    task_jacobian: np.ndarray
    condensing: Condensing
    v_d: np.ndarray

    @cached_property
    def H(self) -> np.ndarray:
        """Hessian (m N, m N), symmetric; formed when it is first used."""
        return hessian(self.condensing, self.C)

    @property
    def qp(self) -> QuadraticProgram:
        """The program without what it is formed from."""
        return QuadraticProgram(self.H, self.g, self.A, self.lower, self.upper)


class MpcFormulation:
    """Forms the program of one tick; constant parts are computed once.

    With s_k = [p_B', q'] and the end-effector linearised at the tick,

        J_1 = | J_s s_k + J_yaw yaw' + J_u xi_u' - p_Ed,k' + K_e e_E,k |^2  W_1
        J_2 = | s_k |^2                                                    W_2
        J_3 = | u_k |^2                                                    W_3
        J_4 = | p_EB,k - p_O |^2                                           W_4
        J_5 = | p_B,d,k'' - p_B,d,k-1'' |^2                                W_5
        J_6 = | t_k' - d_k' + K_o (t_k - d_k) |^2                          W_6

    summed over the stages 1 ... N (J_3: 0 ... N-1, since u_N has no effect). All
    but J_5 are multiplied by the ticks that a stage lasts. J_5 and J_6 are not in the paper.

    J_5 penalises steps of the base acceleration, from the current one on: such steps
    require attitude rates beyond those of the rotors, and rotate the end-effector.

    J_6 is the orientation task and is present if `tick.pointing` is not None. t is the
    direction of the tool axis and d the desired one; rotation about the axis is free.
    t has the same form as p_E, t' = J_s s + J_yaw yaw' + J_u xi_u', with its own
    Jacobians and r = t, and with K_o and `approach_speed_rad_s` in place of K_e and
    `approach_speed_m_s` below.

    e_E,k is predicted with the same linearisation, or frozen at e_E,0 as printed in the
    paper (`config.error`). K_e is scaled down if the correction of e_E,0 would exceed
    `config.approach_speed_m_s`.

    `config.tilt` selects the prediction of roll and pitch. `none`: they are constant. `held`:
    their measured rates are constant over the horizon. `flatness`: the thrust axis tilts with the
    model's acceleration a of the base, which moves the end-effector by T a, T = -[r]x [z]x / g,
    at the mean rate T (a_k - a_{k-1}) / (t_k - t_{k-1}); in models without a, as `none`.

    Args:
        config: Weights, horizon and limits of the base.
        model: The equivalent model.
        vehicle: Gives the centre of the learning space and the limits of the joints.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        self.config, self.model = config, model
        self.limits = limits = SetpointLimits.make(config, vehicle)
        self.stage_ticks = ticks = stage_ticks(config)
        self.states = StageStates(model, ticks)
        self.scale = np.repeat(limits.acceleration, config.horizon)
        self._p_O = vehicle.p_O
        w_2_joints = vehicle.per_joint(config.w_2_joints, "mpc.w_2_joints")
        w_3_joints = vehicle.per_joint(config.w_3_joints, "mpc.w_3_joints")
        self._K_e, self._K_o = np.array(config.k_e), np.full(3, config.k_o)
        self._W_1, self._W_6 = np.array(config.w_1), np.full(3, config.w_6)
        self.W_2 = np.array([*config.w_2_base, *w_2_joints])
        self._W_4 = np.array(config.w_4)
        self._setpoint_rates = np.concatenate([model.setpoint_velocity, model.joint_velocity])
        self._is_base = np.arange(len(self.W_2)) < 3
        # The measured yaw rate is used always, those of roll and pitch only with tilt `held`.
        self._rates = np.array([1.0, 1.0, 1.0] if config.tilt == "held" else [0.0, 0.0, 1.0])
        W_3 = np.array([*config.w_3_base, *w_3_joints])
        W_5 = np.array([*config.w_5, *np.zeros(model.joints)])
        self._w_5 = W_5 * limits.acceleration
        change = np.eye(config.horizon) - np.eye(config.horizon, k=-1)
        H_input = np.multiply.outer(W_3, np.diag(ticks)) + np.multiply.outer(W_5, change.T @ change)
        H_input *= limits.acceleration[:, None, None] ** 2
        outputs = StageOutputs(model, self.states, model.dt * ticks, limits.acceleration)
        self.condensing = Condensing.make(outputs, ticks, H_input)
        self._form_rows(outputs)

    def _form_rows(self, outputs: StageOutputs) -> None:
        """Computes the bounds on states as unit-norm rows over z.

        Bounded are the base setpoint velocity and joint positions and velocities at each
        stage, and the terminal braking distance: q + t_s q' within the position limits. With
        t_s = v_max / (2 a_max), which no joint exceeds, feasibility is recursive if the
        horizon lasts 2 t_s or longer and each stage is one tick. With longer stages it is
        not guaranteed: then bounds are `relaxed`, and the setpoint integrator enforces
        the limits.
        """
        model, limits, states = self.model, self.limits, self.states
        high = np.concatenate([limits.velocity[:3], limits.upper[3:], limits.velocity[3:]])
        low = np.concatenate([-limits.velocity[:3], limits.lower[3:], -limits.velocity[3:]])
        bounded = np.concatenate(
            [model.setpoint_velocity, model.joint_position, model.joint_velocity]
        )
        t_stop = limits.velocity[3:] / (2 * limits.acceleration[3:])

        def rows(x: np.ndarray) -> np.ndarray:
            """Returns the bounded quantities (rows, ...) of states (N, nx, ...)."""
            brake = x[-1, model.joint_position] + t_stop[:, None] * x[-1, model.joint_velocity]
            return np.vstack([x[:, bounded].reshape(len(x) * len(high), -1), brake])

        N, m = self.config.horizon, len(limits.acceleration)
        by_input = rows(states.Gamma).reshape(-1, N, m) * limits.acceleration
        A = by_input.transpose(0, 2, 1).reshape(-1, m * N)
        norms = np.linalg.norm(A, axis=1)
        self.A = A / norms[:, None]
        self._upper = np.concatenate([np.tile(high, N), limits.upper[3:]]) / norms
        self._lower = np.concatenate([np.tile(low, N), limits.lower[3:]]) / norms
        # Free response of the rows and of the outputs, per [x_0, Delta].
        of_rows = np.hstack([rows(states.Phi), rows(states.Psi)]) / norms[:, None]
        of_outputs = outputs.free_response.reshape(-1, of_rows.shape[1])
        self._free_response = np.vstack([of_rows, of_outputs])

    def form(self, tick: MpcInputs) -> MpcProgram:
        """Returns the program of one tick."""
        config, end_effector = self.config, tick.end_effector
        response = self._free_response @ np.concatenate([tick.x_0, tick.delta])
        rows, outputs = response[: len(self.A)], response[len(self.A) :]
        free_response = outputs.reshape(-1, config.horizon)
        W_2 = self.W_2 * np.where(self._is_base, tick.w_q, tick.w_m)
        W_4, offset = self._W_4 * tick.w_d, end_effector.p_EB - self._p_O
        cost = posture_cost(config.horizon, W_2, W_4, end_effector.J_B, offset)
        rpy_rates = tick.rpy_rates * self._rates
        tilts, is_predicted = config.tilt == "flatness", config.error == "predicted"
        for task in self._tasks(tick):
            add_tracking(cost, task, rpy_rates, tilts, is_predicted)
        g = gradient(self.condensing, cost, free_response)
        g[:: config.horizon] -= self._w_5 * tick.u_last
        task_jacobian = end_effector.J_B
        if tick.pointing is not None:
            task_jacobian = np.vstack([task_jacobian, tick.pointing.axis.J_c[:, 4:]])
        return MpcProgram(
            g=g,
            A=self.A,
            lower=self._lower - rows,
            upper=self._upper - rows,
            free_response=free_response,
            C=cost.C,
            task_jacobian=task_jacobian,
            condensing=self.condensing,
            v_d=tick.x_0[self._setpoint_rates],
        )

    def relaxed(self, program: MpcProgram) -> MpcProgram:
        """Returns the program with bounds widened so far that full braking is feasible.

        Bounds that full braking satisfies are unchanged. The others cannot be satisfied by
        any input, and the relaxed program exceeds them by no more than braking does.
        """
        z = braking(program.v_d, self.limits.acceleration, self.model.dt * self.stage_ticks)
        rows = self.A @ z
        return replace(
            program,
            lower=np.minimum(program.lower, rows - SLACK),
            upper=np.maximum(program.upper, rows + SLACK),
        )

    def inputs(self, z: np.ndarray) -> np.ndarray:
        """Returns u_0 ... u_{N-1} (N, m) in m/s^2 and rad/s^2 from z (m N,)."""
        return (self.scale * z).reshape(-1, self.config.horizon).T

    def predict(self, tick: MpcInputs, program: MpcProgram, U: np.ndarray) -> np.ndarray:
        """Returns the linearised p_E (N + 1, 3) m now and at each stage under U (N, 3 + n)."""
        y = outputs_under(self.condensing, program.free_response, U.T.ravel() / self.scale)
        at, tilts = tick.end_effector, self.config.tilt == "flatness"
        return predict_task(at.p_E, at.r, at.J_c, tilts, y)

    def _tasks(self, tick: MpcInputs) -> Iterator[TrackingTask]:
        """Yields the task of J_1 and, if there is one, that of J_6."""
        position, pointing = tick.end_effector, tick.pointing
        tasks = [(position, tick.reference, self._K_e, self._W_1, self.config.approach_speed_m_s)]
        if pointing is not None:
            speed = self.config.approach_speed_rad_s
            tasks.append((pointing.axis, pointing.reference, self._K_o, self._W_6, speed))
        for task, reference, K, W, speed in tasks:
            K = limited_gain(K, task.value - reference[0, :3], speed)
            yield TrackingTask(task.value, task.r, task.J_c, task.J_u, reference, K, W)

"""The MPC's cost and bounds, formed as a condensed quadratic program (paper, section III-A, B)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.condensing import Condensing, driven, gradient, hessian
from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.model.mpc.posture import posture_cost
from aerodrake.model.mpc.prediction import Prediction
from aerodrake.model.mpc.stage_outputs import StageOutputs
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.mpc.tracking import add_tracking, carried_along, limited_gain
from aerodrake.model.setpoint.braking import braking
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.vehicle.kinematics import TaskVector
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc

SLACK = 1e-6
"""Of scaled rows: what relaxed bounds leave to full braking."""


@dataclass(frozen=True)
class MpcProgram:
    """min z' H z / 2 + g' z with |z| <= 1 and lower <= A z <= upper.

    z (m N,) has the scaled inputs axis by axis: first all stages of the first.

    Attributes:
        g: (m N,).
        lower, upper: (rows,).
        free: (F, N), the stages' outputs under zero input.
        C: (F, F), the cost of a stage's outputs y is y' C y, beside what is linear in y.
        task_jacobian: (k, n), how the joints move what the cost has wishes for.
        condensing: What makes H of C.
        v_d: (m,) of the setpoints now, m/s and rad/s.
    """

    g: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    free: np.ndarray
    C: np.ndarray
    task_jacobian: np.ndarray
    condensing: Condensing
    v_d: np.ndarray

    @cached_property
    def H(self) -> np.ndarray:
        """(m N, m N), symmetric."""
        return hessian(self.condensing, self.C)


class MpcFormulation:
    """Forms the program of one tick; everything constant is computed once.

    With s_k = [p_B', q'] and the end-effector linearised at the tick,

        J_1 = | J_s s_k + J_yaw yaw' + J_u xi_u' - p_Ed,k' + K_e e_E,k |^2  W_1
        J_2 = | s_k |^2                                                    W_2
        J_3 = | u_k |^2                                                    W_3
        J_4 = | p_EB,k - p_O |^2                                           W_4
        J_5 = | p_B,d,k'' - p_B,d,k-1'' |^2                                W_5
        J_6 = | t_k' - d_k' + K_o (t_k - d_k) |^2                          W_6

    summed over the stages 1 ... N (J_3: 0 ... N-1, since u_N moves nothing), all
    but J_5 times the ticks that a stage lasts. J_5 and J_6 are not the paper's.
    J_5 starts from the acceleration until now: its steps make the base turn faster
    than rotors can, and turn the end-effector with it. J_6, the orientation task,
    stands only where `tick.pointing` does: t is the direction of the tool's axis,
    d the one it is to have, and how the tool is turned about its axis is left free.
    t moves as p_E does: t' = J_s s + J_yaw yaw' + J_u xi_u', with Jacobians of its
    own and t for r. All that follows is meant for it, too, K_o and
    `approach_speed_rad_s` in place of K_e and its speed.
    e_E,k is predicted with the same linearisation, or frozen at e_E,0 as the
    paper prints it; K_e is scaled down while e_E,0 is so large that the
    correction would exceed `config.approach_speed_m_s`. Roll and pitch follow
    by `config.tilt`: `none`; `held`, their measured rates over the whole
    horizon; or `flatness`: the thrust axis tilts with the model's acceleration a
    of the base, which moves the end-effector by T a, T = -[r]x [z]x / g, and at
    T (a_k - a_{k-1}) / (t_k - t_{k-1}) on its way to a stage. So does nothing in
    models without such an acceleration.

    Args:
        config: Weights and bounds.
        model: The equivalent model.
        limits: Of the setpoints, (3 + n): base velocity, joint positions and
            velocities, and all accelerations.
        vehicle: For the centre of the learning space.
    """

    def __init__(
        self,
        config: Mpc,
        model: EquivalentModel,
        limits: SetpointLimits,
        vehicle: VehicleModel,
    ):
        self.config, self.model, self.limits = config, model, limits
        self.stage_ticks = ticks = stage_ticks(config)
        self.prediction = Prediction(model, ticks)
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
        # Roll and pitch rates count where they are held; yaw's always.
        self._rates = np.array([1.0, 1.0, 1.0] if config.tilt == "held" else [0.0, 0.0, 1.0])
        W_3 = np.array([*config.w_3_base, *w_3_joints])
        W_5 = np.array([*config.w_5, *np.zeros(model.joints)])
        self._w_5 = W_5 * limits.acceleration
        change = np.eye(config.horizon) - np.eye(config.horizon, k=-1)
        H_input = np.multiply.outer(W_3, np.diag(ticks)) + np.multiply.outer(W_5, change.T @ change)
        H_input *= limits.acceleration[:, None, None] ** 2
        outputs = StageOutputs(model, self.prediction, model.dt * ticks, limits.acceleration)
        self.condensing = Condensing.make(outputs, ticks, H_input)
        self._form_rows(outputs)

    def _form_rows(self, outputs: StageOutputs) -> None:
        """Bounds on states as unit-norm rows over z.

        Base setpoint velocity, joint positions and velocities at each stage;
        and at the last one, room to brake: q + t_s q' within the limits. With
        t_s = v_max / (2 a_max) no joint needs more, so that the next tick's
        program is feasible if this one was, the horizon lasts 2 t_s or longer, and
        each stage is one tick. With longer stages that is not certain: then bounds are
        `relaxed`, and the setpoint integrator keeps the limits.
        """
        model, limits, prediction = self.model, self.limits, self.prediction
        high = np.concatenate([limits.velocity[:3], limits.upper[3:], limits.velocity[3:]])
        low = np.concatenate([-limits.velocity[:3], limits.lower[3:], -limits.velocity[3:]])
        bounded = np.concatenate(
            [model.setpoint_velocity, model.joint_position, model.joint_velocity]
        )
        t_stop = limits.velocity[3:] / (2 * limits.acceleration[3:])

        def rows(x: np.ndarray) -> np.ndarray:
            """What is bounded, of states (N, nx, ...)."""
            brake = x[-1, model.joint_position] + t_stop[:, None] * x[-1, model.joint_velocity]
            return np.vstack([x[:, bounded].reshape(len(x) * len(high), -1), brake])

        N, m = self.config.horizon, len(limits.acceleration)
        by_input = rows(prediction.Gamma).reshape(-1, N, m) * limits.acceleration
        A = by_input.transpose(0, 2, 1).reshape(-1, m * N)
        norms = np.linalg.norm(A, axis=1)
        self.A = A / norms[:, None]
        self._upper = np.concatenate([np.tile(high, N), limits.upper[3:]]) / norms
        self._lower = np.concatenate([np.tile(low, N), limits.lower[3:]]) / norms
        free = np.hstack([rows(prediction.Phi), rows(prediction.Psi)]) / norms[:, None]
        # The rows and the outputs without inputs, per [x_0, Delta].
        self._free = np.vstack([free, outputs.free.reshape(-1, free.shape[1])])

    def form(self, tick: MpcInputs) -> MpcProgram:
        """The program of one tick."""
        config, end_effector = self.config, tick.end_effector
        free = self._free @ np.concatenate([tick.x_0, tick.delta])
        rows, free = free[: len(self.A)], free[len(self.A) :].reshape(-1, config.horizon)
        C, c = posture_cost(
            config.horizon,
            self.W_2 * np.where(self._is_base, tick.w_q, tick.w_m),
            self._W_4 * tick.w_d,
            end_effector.J_B,
            end_effector.p_EB - self._p_O,
        )
        for y, reference, K, W in self._targets(tick):
            add_tracking(
                C,
                c,
                y.value,
                y.r,
                y.J_c,
                y.J_u,
                tick.rpy_rates * self._rates,
                reference,
                K,
                W,
                config.tilt == "flatness",
                config.error == "predicted",
            )
        g = gradient(self.condensing, C, c, free)
        g[:: config.horizon] -= self._w_5 * tick.u_last
        task_jacobian = end_effector.J_B
        if tick.pointing is not None:
            task_jacobian = np.vstack([task_jacobian, tick.pointing.axis.J_c[:, 4:]])
        v_d = tick.x_0[self._setpoint_rates]
        return MpcProgram(
            g, self._lower - rows, self._upper - rows, free, C, task_jacobian, self.condensing, v_d
        )

    def relaxed(self, program: MpcProgram) -> MpcProgram:
        """The program with bounds as wide as it takes: full braking keeps them.

        A bound that braking keeps stays as it is. Others cannot be kept, since nothing takes
        off speed faster, and there the program is to do no worse than braking.
        """
        z = braking(program.v_d, self.limits.acceleration, self.model.dt * self.stage_ticks)
        rows = self.A @ z
        return replace(
            program,
            lower=np.minimum(program.lower, rows - SLACK),
            upper=np.maximum(program.upper, rows + SLACK),
        )

    def inputs(self, z: np.ndarray) -> np.ndarray:
        """(N, m), u_0 ... u_{N-1} in m/s^2 and rad/s^2, of the program's z (m N,)."""
        return (self.scale * z).reshape(-1, self.config.horizon).T

    def predict(self, tick: MpcInputs, program: MpcProgram, U: np.ndarray) -> np.ndarray:
        """(N + 1, 3) m, p_E now and at each stage under U (N, 3 + n), as linearised."""
        y = driven(self.condensing, program.free, U.T.ravel() / self.scale)
        at, tilts = tick.end_effector, self.config.tilt == "flatness"
        return carried_along(at.p_E, at.r, at.J_c, tilts, y)

    def _targets(
        self, tick: MpcInputs
    ) -> Iterator[tuple[TaskVector, np.ndarray, np.ndarray, np.ndarray]]:
        """What is to follow, its reference, K and W: of J_1, and of J_6 where there is one."""
        config, pointing = self.config, tick.pointing
        error = tick.end_effector.p_E - tick.reference[0, :3]
        K_e = limited_gain(self._K_e, error, config.approach_speed_m_s)
        yield tick.end_effector, tick.reference, K_e, self._W_1
        if pointing is not None:
            error = pointing.axis.value - pointing.reference[0, :3]
            K_o = limited_gain(self._K_o, error, config.approach_speed_rad_s)
            yield pointing.axis, pointing.reference, K_o, self._W_6

"""The MPC's cost and bounds, formed as a condensed quadratic program (paper, section III-A, B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.horizon import stage_ticks
from aerodrake.model.mpc_inputs import MpcInputs
from aerodrake.model.prediction import Prediction
from aerodrake.model.setpoint import SetpointLimits
from aerodrake.model.tracking import Target, Tracking, limited_gain
from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Mpc


@dataclass(frozen=True)
class MpcProgram:
    """min z' H z / 2 + g' z with |z| <= 1 and lower <= A z <= upper; u = scale z.

    `x_free` (N, nx) are the states under zero input.
    """

    H: np.ndarray
    g: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    x_free: np.ndarray


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
        vehicle: Vehicle,
    ):
        self.config, self.model, self.limits = config, model, limits
        self._p_O = vehicle.p_O
        w_2_joints = vehicle.per_joint(config.w_2_joints, "mpc.w_2_joints")
        w_3_joints = vehicle.per_joint(config.w_3_joints, "mpc.w_3_joints")
        N, m = config.horizon, 3 + model.joints
        self.stage_ticks = ticks = stage_ticks(config)
        self.prediction = Prediction(model, ticks)
        self._ticks = np.repeat(ticks, 3)
        self.scale = np.tile(limits.acceleration, N)
        self._tracking = Tracking(config, model, self.prediction, ticks, self.scale)
        # Everything below is per scaled input z.
        self._Gamma = self.prediction.Gamma * self.scale
        # J_2's shares of base and joints, which the allocator weighs anew each tick.
        self._base_rows = self._Gamma[:, model.base_velocity].reshape(3 * N, -1)
        self._joint_rows = self._Gamma[:, model.joint_velocity].reshape(model.joints * N, -1)
        self._w_2_base = np.tile(config.w_2_base, N) * self._ticks
        self._w_2_joints = np.tile(w_2_joints, N) * np.repeat(ticks, model.joints)
        self._H_base = self._base_rows.T @ (self._w_2_base[:, None] * self._base_rows)
        self._H_joints = self._joint_rows.T @ (self._w_2_joints[:, None] * self._joint_rows)
        w_3 = np.tile([*config.w_3_base, *w_3_joints], N) * np.repeat(ticks, m)
        w_5 = np.tile([*config.w_5, *np.zeros(model.joints)], N)
        changes = np.eye(N * m) - np.eye(N * m, k=-m)
        changes = changes * self.scale
        self._H_input = np.diag(w_3 * self.scale**2) + changes.T @ (w_5[:, None] * changes)
        self._g_last = -(w_5 * self.scale)[:m]
        self._form_rows()

    def _form_rows(self) -> None:
        """Bounds on states as unit-norm rows over z.

        Base setpoint velocity, joint positions and velocities at each stage;
        and at the last one, room to brake: q + t_s q' within the limits. With
        t_s = v_max / (2 a_max) no joint needs more, so that the next tick's
        program is feasible if this one was, the horizon lasts 2 t_s or longer, and
        each stage is one tick. With longer stages that is not certain: then the last
        plan goes on, and the setpoint integrator keeps the limits.
        """
        model, limits, N = self.model, self.limits, self.config.horizon
        self._bounded = np.concatenate(
            [model.setpoint_velocity, model.joint_position, model.joint_velocity]
        )
        high = np.concatenate([limits.velocity[:3], limits.upper[3:], limits.velocity[3:]])
        low = np.concatenate([-limits.velocity[:3], limits.lower[3:], -limits.velocity[3:]])
        self._t_stop = limits.velocity[3:] / (2 * limits.acceleration[3:])
        brake = self._Gamma[-1][model.joint_position] + (
            self._t_stop[:, None] * self._Gamma[-1][model.joint_velocity]
        )
        rows = np.vstack([self._Gamma[:, self._bounded].reshape(N * len(high), -1), brake])
        norms = np.linalg.norm(rows, axis=1)
        self.A = rows / norms[:, None]
        self._row_norms = norms
        self._upper = np.concatenate([np.tile(high, N), limits.upper[3:]])
        self._lower = np.concatenate([np.tile(low, N), limits.lower[3:]])

    def form(self, tick: MpcInputs) -> MpcProgram:
        """The program of one tick."""
        x_free = self.prediction.free(tick.x_0, tick.delta)
        H, g = self._H_input.copy(), np.zeros(len(self.scale))
        g[: len(tick.u_last)] = self._g_last * tick.u_last
        costs = [self._tracking.cost(target, tick, x_free) for target in self._targets(tick)]
        for rows, offset, weight in (*costs, self._centring(tick, x_free)):
            weighted = weight[:, None] * rows
            H += rows.T @ weighted
            g += weighted.T @ offset
        H += tick.w_q * self._H_base + tick.w_m * self._H_joints
        model = self.model
        g += tick.w_q * (
            self._base_rows.T @ (self._w_2_base * x_free[:, model.base_velocity].ravel())
        )
        g += tick.w_m * (
            self._joint_rows.T @ (self._w_2_joints * x_free[:, model.joint_velocity].ravel())
        )
        values = np.concatenate(
            [
                x_free[:, self._bounded].ravel(),
                x_free[-1, model.joint_position] + self._t_stop * x_free[-1, model.joint_velocity],
            ]
        )
        return MpcProgram(
            H=H,
            g=g,
            lower=(self._lower - values) / self._row_norms,
            upper=(self._upper - values) / self._row_norms,
            x_free=x_free,
        )

    def predict(self, tick: MpcInputs, program: MpcProgram, U: np.ndarray) -> np.ndarray:
        """(N + 1, 3) m, p_E now and at each stage under U (N (3 + n),), as linearised."""
        x = np.vstack([tick.x_0, program.x_free + self.prediction.Gamma @ U])
        return tick.end_effector.p_E + (x - tick.x_0) @ self._tracking.places(tick.end_effector).T

    def _targets(self, tick: MpcInputs) -> list[Target]:
        """Of J_1, and of J_6 where the tool is to point somewhere."""
        config, pointing = self.config, tick.pointing
        K_e = correction_gain(config, tick)
        targets = [Target(tick.end_effector, tick.reference, K_e, np.array(config.w_1))]
        if pointing is not None:
            error = pointing.axis.value - pointing.reference[0, :3]
            K_o = limited_gain(np.full(3, config.k_o), error, config.approach_speed_rad_s)
            targets.append(Target(pointing.axis, pointing.reference, K_o, np.full(3, config.w_6)))
        return targets

    def _centring(
        self, tick: MpcInputs, x_free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """J_4 as (rows over z, offset, weight)."""
        model, end_effector, N = self.model, tick.end_effector, self.config.horizon
        joints = model.joint_position
        moved = x_free[:, joints] - tick.x_0[joints]
        offset = end_effector.p_EB - self._p_O + moved @ end_effector.J_B.T
        rows = end_effector.J_B @ self._Gamma[:, joints]
        weight = np.tile(np.multiply(tick.w_d, self.config.w_4), N) * self._ticks
        return rows.reshape(3 * N, -1), offset.ravel(), weight


def correction_gain(config: Mpc, tick: MpcInputs) -> np.ndarray:
    """(3,) 1/s, K_e, scaled down where K_e e_E,0 exceeds the approach speed."""
    error = tick.end_effector.p_E - tick.reference[0, :3]
    return limited_gain(np.array(config.k_e), error, config.approach_speed_m_s)

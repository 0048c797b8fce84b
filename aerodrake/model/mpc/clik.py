"""Weighted closed-loop inverse kinematics with damped least squares."""

from dataclasses import dataclass

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.mpc.objective import limited_gain
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clik, Mpc
from aerodrake.support.arguments import checked


@dataclass(frozen=True)
class ClikCommand:
    """Command of one tick.

    Attributes:
        velocity: (3 + n,) m/s and rad/s, desired velocity of [p_B, q].
        u: (3 + n,) m/s^2 and rad/s^2, within the bounds.
        is_clipped: True if a bound changed u.
    """

    velocity: np.ndarray
    u: np.ndarray
    is_clipped: bool


class InverseKinematics:
    """Resolves the desired velocity of the end-effector into those of base and joints.

    With s = [p_B', q'], J = J_s and W = diag(w_q, ..., w_m, ...), scaled so that its
    smallest weight is 1,

        s   = s_0 + W^-1 J^T (J W^-1 J^T + lambda^2 I)^-1 v
        v   = p_Ed' - K_e e_E - J_yaw yaw'
        s_0 = [-R_B J_B q_0', q_0'],  q_0' = -k_c J_B^T (J_B J_B^T + lambda^2 I)^-1 (p_EB - p_O)

    s_0 is a null-space motion of J that descends the paper's J_4: it returns the arm
    to its learning space without moving the end-effector. p_Ed' is taken at the next
    tick. Roll and pitch rates are treated as disturbances, which K_e rejects. The
    accelerations are those of a first-order loop, u = k (s - s_d), clipped to their bounds.

    Damped least squares: Nakamura and Hanafusa (1986), Wampler (1986). Weights and null
    space: Chiaverini, Siciliano and Egeland (1994).

    Args:
        config: Damping and rates.
        mpc: Gives K_e, the approach speed and the limits of the base.
        model: Gives the period and the indices of the setpoints in x_0.
        vehicle: Gives the centre of the learning space and the limits of the joints.
    """

    @checked
    def __init__(self, config: Clik, mpc: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        self.mpc, self.model = mpc, model
        self._config, self._p_O = config, vehicle.p_O
        self._acceleration = SetpointLimits.make(mpc, vehicle).acceleration
        self._stages_s = stage_times(mpc, model.dt)

    def command(self, tick: MpcInputs) -> ClikCommand:
        """Returns the command of one tick.

        Args:
            tick: Only the setpoints of x_0 are used; delta is not.
        """
        velocity = self._centring(tick) + self._tracking(tick)
        model = self.model
        commanded = tick.x_0[np.concatenate([model.setpoint_velocity, model.joint_velocity])]
        unbounded = self._config.bandwidth_1_s * (velocity - commanded)
        u = np.clip(unbounded, -self._acceleration, self._acceleration)
        return ClikCommand(velocity, u, bool(np.any(u != unbounded)))

    def predict(self, tick: MpcInputs, velocity: np.ndarray) -> np.ndarray:
        """Returns p_E (N + 1, 3) m now and at each stage at constant `velocity`.

        Args:
            tick: Inputs of the tick.
            velocity: (3 + n,) m/s and rad/s, of [p_B, q].
        """
        return tick.end_effector.p_E + np.outer(self._stages_s, tick.end_effector.J_s @ velocity)

    def _tracking(self, tick: MpcInputs) -> np.ndarray:
        """Returns s - s_0 (3 + n,): the weighted, damped inverse of v."""
        J, n = tick.end_effector.J_s, self.model.joints
        W = np.array([tick.w_q] * 3 + [tick.w_m] * n)
        weighted = J / (W / W.min())
        e = tick.end_effector.p_E - tick.reference[0, :3]
        K_e = limited_gain(np.array(self.mpc.k_e), e, self.mpc.approach_speed_m_s)
        v = tick.reference[1, 3:] - K_e * e - tick.end_effector.J_yaw * tick.rpy_rates[2]
        return weighted.T @ np.linalg.solve(weighted @ J.T + self._damping, v)

    def _centring(self, tick: MpcInputs) -> np.ndarray:
        """Returns s_0 (3 + n,)."""
        J_B, offset = tick.end_effector.J_B, tick.end_effector.p_EB - self._p_O
        descent = np.linalg.solve(J_B @ J_B.T + self._damping, offset)
        rate = -self._config.centring_1_s * J_B.T @ descent
        return np.concatenate([-tick.end_effector.J_s[:, 3:] @ rate, rate])

    @property
    def _damping(self) -> np.ndarray:
        return self._config.damping**2 * np.eye(3)

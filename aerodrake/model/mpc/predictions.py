"""Quantities that the MPC predicts at each stage, affine in the outputs of the model."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.horizon import OutputSlices
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.vehicle.kinematics import TaskVector, ToolAxis
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.errors import BadInput

QUANTITIES = {
    "tool_position": "p_E in m, world frame",
    "tool_velocity": "p_E' in m/s, world frame",
    "tool_position_base": "p_EB in m, base frame",
    "tool_axis": "t, a unit vector in the world frame; with an orientation task only",
    "tool_axis_rate": "t' in 1/s, world frame; with an orientation task only",
    "base_position": "p_B in m, world frame",
    "velocity": "v_s = [p_B', q'] in m/s and rad/s",
    "joint_position": "q in rad",
    "input": "u = [p_B,d'', q''] in m/s^2 and rad/s^2, during the stage",
}
"""Predicted quantities by name, with symbol, unit and frame."""


def quantity_size(quantity: str, joints: int) -> int:
    """Returns the number of entries of one of `QUANTITIES`, for n `joints`."""
    return {"velocity": 3 + joints, "input": 3 + joints, "joint_position": joints}.get(quantity, 3)


class Prediction(NamedTuple):
    """rows y_k + offset_k, a quantity at the end of stage k, with y of `OutputMap`.

    Attributes:
        rows: (d, F).
        offset: (d, N), or (d, 1) if it is the same at all stages.
    """

    rows: np.ndarray
    offset: np.ndarray


class StagePredictions:
    """Predictions of one tick, an attribute for each of `QUANTITIES` but the input.

    The end-effector is linearised at the measured state, with r from the base to it,

        p_E,k  = p_E + J_s [p_B,k - p_B,0; q_k - q_0] + T (a_k - a_0),
        p_E,k' = J_s [p_B,k'; q_k'] + T a_k' + J_yaw yaw' + J_u xi_u',

    and so is the tool's axis t with its own Jacobians and r = t. T is zero unless `tilts`.

    yaw' and xi_u' are constant in the rates, as printed in the paper (or zero, see
    `MpcFormulation`), but p_E,k does not advance with them: the attitude loop returns to its
    setpoint long before the end of the horizon. Advancing p_E,k with yaw', constant or decaying
    with the yaw loop, or leaving yaw' out of the rate changes the errors by 2 % or less, also with
    noisy rates; advancing it with xi_u' destabilises the flight.

    Args:
        tick: Inputs of the tick.
        model: The equivalent model.
        tilts: True if the base's predicted acceleration tilts it (`mpc.tilt` is `flatness`).
        rpy_rates: (3,) rad/s, roll', pitch' and yaw'.

    Raises:
        BadInput: by the tool's axis and its rate, without an orientation task.
    """

    def __init__(self, tick: MpcInputs, model: EquivalentModel, tilts: bool, rpy_rates: np.ndarray):
        self._tick, self._model, self._tilts, self._rpy_rates = tick, model, tilts, rpy_rates
        self._y = OutputSlices.of(model.joints)

    @property
    def stages(self) -> int:
        """Number N of stages."""
        return len(self._tick.reference) - 1

    def __getitem__(self, quantity: str) -> Prediction:
        return getattr(self, quantity)

    @cached_property
    def tool_position(self) -> Prediction:
        """p_E."""
        return self._task_vector(self._tick.end_effector)

    @cached_property
    def tool_velocity(self) -> Prediction:
        """p_E'."""
        return self._task_rate(self._tick.end_effector)

    @cached_property
    def tool_axis(self) -> Prediction:
        """t."""
        return self._task_vector(self._axis)

    @cached_property
    def tool_axis_rate(self) -> Prediction:
        """t'."""
        return self._task_rate(self._axis)

    @cached_property
    def tool_position_base(self) -> Prediction:
        """p_EB."""
        rows, at = self._zeros(3), self._tick.end_effector
        rows[:, self._y.joint_position] = at.J_B
        return Prediction(rows, at.p_EB[:, None])

    @cached_property
    def base_position(self) -> Prediction:
        """p_B."""
        rows, model = self._zeros(3), self._model
        rows[:, self._y.base_position] = np.eye(3)
        return Prediction(rows, self._tick.x_0[model.base_position, None])

    @cached_property
    def joint_position(self) -> Prediction:
        """q."""
        rows, model = self._zeros(self._model.joints), self._model
        rows[:, self._y.joint_position] = np.eye(model.joints)
        return Prediction(rows, self._tick.x_0[model.joint_position, None])

    @cached_property
    def velocity(self) -> Prediction:
        """v_s = [p_B', q']."""
        m = 3 + self._model.joints
        return Prediction(np.eye(m, 2 * m + 6), np.zeros((m, 1)))

    @property
    def _axis(self) -> ToolAxis:
        if self._tick.pointing is None:
            raise BadInput("tool_axis", "", "expected a scenario with an orientation task")
        return self._tick.pointing.axis

    def _zeros(self, size: int) -> np.ndarray:
        return np.zeros((size, self._y.acceleration_rate.stop))

    def _task_vector(self, task: TaskVector) -> Prediction:
        rows, y = self._zeros(3), self._y
        rows[:, y.base_position], rows[:, y.joint_position] = task.J_c[:, :3], task.J_c[:, 4:]
        if self._tilts:
            rows[:, y.acceleration] = tilt_matrix(task.r)
        return Prediction(rows, task.value[:, None])

    def _task_rate(self, task: TaskVector) -> Prediction:
        rows, y = self._zeros(3), self._y
        rows[:, y.base_velocity], rows[:, y.joint_velocity] = task.J_c[:, :3], task.J_c[:, 4:]
        if self._tilts:
            rows[:, y.acceleration_rate] = tilt_matrix(task.r)
        turning = task.J_u @ self._rpy_rates[:2] + task.J_c[:, 3] * self._rpy_rates[2]
        return Prediction(rows, turning[:, None])


def tilt_matrix(r: np.ndarray) -> np.ndarray:
    """Returns T (3, 3) s^2: a base acceleration a tilts the base, which moves r by T a.

    T = -[r]x [z]x / g, with r (3,) from the base to the end-effector in the world, or along
    its axis, for tilts so small that the thrust stays close to the weight.
    """
    x, y, z = r.tolist()
    return np.array([[z, 0.0, 0.0], [0.0, z, 0.0], [-x, -y, 0.0]]) / GRAVITY

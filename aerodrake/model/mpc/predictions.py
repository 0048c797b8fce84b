"""Quantities that the MPC predicts at each stage, affine in the outputs of the model."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.horizon import OutputSlices, output_slices
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.vehicle.kinematics import TaskVector
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.errors import BadInput

QUANTITIES = {
    "tool_position": "p_E in m, world frame",
    "tool_velocity": "p_E' in m/s, world frame",
    "tool_position_base": "p_EB in m, base frame",
    "tool_velocity_base": "p_EB' in m/s, base frame",
    "tool_axis": "t, a unit vector in the world frame; with an orientation task only",
    "tool_axis_rate": "t' in 1/s, world frame; with an orientation task only",
    "base_position": "p_B in m, world frame",
    "base_velocity": "p_B' in m/s, world frame",
    "joint_position": "q in rad",
    "joint_velocity": "q' in rad/s",
    "input": "u = [p_B,d'', q''] in m/s^2 and rad/s^2, during the stage",
}
"""Predicted quantities by name, with symbol, unit and frame.

A further one needs a case in `StagePredictions` and either an index in `TickProgram.quantity` or,
with variables of its own, an entry in its `SYMBOLS` and `DEFINITIONS`.
"""

RATES = {
    "tool_position": "tool_velocity",
    "tool_position_base": "tool_velocity_base",
    "tool_axis": "tool_axis_rate",
    "base_position": "base_velocity",
    "joint_position": "joint_velocity",
}
"""Name of the rate of each quantity that has one in `QUANTITIES`."""


def quantity_size(quantity: str, joints: int) -> int:
    """Returns the number of entries of one of `QUANTITIES`, for n `joints`."""
    if quantity == "input":
        return 3 + joints
    return joints if quantity.startswith("joint") else 3


class Prediction(NamedTuple):
    """rows y_k + offset, a quantity at the end of stage k, with y of `OutputMap`.

    Attributes:
        rows: (d, F).
        offset: (d, 1).
    """

    rows: np.ndarray
    offset: np.ndarray


class StagePredictions:
    """Predictions of one tick, by the names of `QUANTITIES` but the input.

    The end-effector is linearised at the measured state, with r from the base to it,

        p_E,k  = p_E + J_s [p_B,k - p_B,0; q_k - q_0] + T (a_k - a_0),
        p_E,k' = J_s [p_B,k'; q_k'] + T a_k' + J_yaw yaw' + J_u xi_u',

    and so is the tool's axis t with its own Jacobians and r = t. T is zero unless `tilts`.

    yaw' and xi_u' are constant in the rates, as printed in the paper (or zero, see
    `MpcProblem`), but p_E,k does not advance with them: the attitude loop returns to its
    setpoint long before the end of the horizon. Advancing p_E,k with yaw', constant or decaying
    with the yaw loop, or leaving yaw' out of the rate changes the errors by about 2 % or less, also
    with noisy rates; advancing it with xi_u' destabilises the flight.

    Args:
        tick: Inputs of the tick.
        model: The equivalent model.
        tilts: True if the base's predicted acceleration tilts it (`mpc.tilt` is `flatness`).
        rpy_rates: (3,) rad/s, roll', pitch' and yaw'.
    """

    def __init__(self, tick: MpcInputs, model: EquivalentModel, tilts: bool, rpy_rates: np.ndarray):
        self._tick, self._model, self.tilts, self._rpy_rates = tick, model, tilts, rpy_rates
        self._positions, self._rates = output_slices(model.joints)

    def __getitem__(self, quantity: str) -> Prediction:
        """Returns the prediction of one of `QUANTITIES`.

        Raises:
            BadInput: if it is the tool's axis or its rate, without an orientation task.
        """
        tick, model, is_rate = self._tick, self._model, quantity in RATES.values()
        at, y = tick.end_effector, self._rates if is_rate else self._positions
        match quantity:
            case "tool_position" | "tool_velocity":
                return self._task(at, y, is_rate)
            case "tool_axis" | "tool_axis_rate":
                if tick.pointing is None:
                    raise BadInput(quantity, "", "expected a scenario with an orientation task")
                return self._task(tick.pointing.axis, y, is_rate)
            case "tool_position_base" | "tool_velocity_base":
                rows, now = self._rows(y.joint, at.J_B), at.p_EB
            case "base_position" | "base_velocity":
                rows, now = self._rows(y.base, np.eye(3)), tick.x_0[model.base_position]
            case "joint_position" | "joint_velocity":
                rows = self._rows(y.joint, np.eye(model.joints))
                now = tick.x_0[model.joint_position]
            case _:
                raise KeyError(quantity)
        return Prediction(rows, np.zeros((len(rows), 1)) if is_rate else now[:, None])

    def _rows(self, part: slice, M: np.ndarray) -> np.ndarray:
        """Returns the rows (d, F) of M times a part of y."""
        rows = np.zeros((len(M), self._rates.tilt.stop))
        rows[:, part] = M
        return rows

    def _task(self, task: TaskVector, y: OutputSlices, is_rate: bool) -> Prediction:
        rows = self._rows(y.base, task.J_c[:, :3])
        rows[:, y.joint] = task.J_c[:, 4:]
        if self.tilts:
            rows[:, y.tilt] = tilt_matrix(task.r)
        if not is_rate:
            return Prediction(rows, task.value[:, None])
        turning = task.J_u @ self._rpy_rates[:2] + task.J_c[:, 3] * self._rpy_rates[2]
        return Prediction(rows, turning[:, None])


def tilt_matrix(r: np.ndarray) -> np.ndarray:
    """Returns T (3, 3) s^2: a base acceleration a tilts the base, which moves r by T a.

    T = -[r]x [z]x / g, with r (3,) from the base to the end-effector in the world, or along
    its axis, for tilts so small that the thrust stays close to the weight.
    """
    x, y, z = r.tolist()
    return np.array([[z, 0.0, 0.0], [0.0, z, 0.0], [-x, -y, 0.0]]) / GRAVITY

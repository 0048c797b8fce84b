"""Objective of the MPC (paper, section III-B): its terms, and their sum at a stage."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from aerodrake.model.mpc.predictions import Prediction, StagePredictions
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc


class CostTerm(NamedTuple):
    """| sum_i M_i x_i,k - desired_k |^2 W of predicted quantities x_i, times the stage's ticks.

    Attributes:
        name: The paper's name, for example `J_1`.
        formula: The term in the paper's symbols.
        parts: (quantity, M_i (d, size)) of each quantity.
        desired: (d, N), or (d, 1) if it is the same at all stages.
        weight: (d,), diagonal of W.
    """

    name: str
    formula: str
    parts: tuple[tuple[str, np.ndarray], ...]
    desired: np.ndarray
    weight: np.ndarray


class StageCost(NamedTuple):
    """y^T C y + 2 c_k^T y, a cost of the outputs y of a stage k.

    Attributes:
        C: (F, F), symmetric.
        c: (F, N).
    """

    C: np.ndarray
    c: np.ndarray


class TrackingTask(NamedTuple):
    """Quantity x that follows a reference, with the cost | x' - x_d' + K (x - x_d) |^2 W.

    Attributes:
        name, formula: As in `CostTerm`.
        quantity, rate: Names of x and x' in `QUANTITIES`.
        gain: (3,) 1/s, diagonal of K.
        weight: (3,), diagonal of W.
        speed: m/s or rad/s, bound of | K (x - x_d) | now.
    """

    name: str
    formula: str
    quantity: str
    rate: str
    gain: np.ndarray
    weight: np.ndarray
    speed: float


class Objective:
    """Terms J_1 to J_4 and J_6 of `MpcProblem`.

    `MpcFormulation` and `TickProgram` sum the same `terms`; a further cost of predicted quantities
    belongs there. Each of them adds J_3 and J_5, the costs of the inputs, in its own form.

    e_E is predicted, or frozen at its current value as printed in the paper (`mpc.error`).
    K_e is scaled down if the correction of the current e_E would exceed `approach_speed_m_s`.

    J_6 is the orientation task, which is not in the paper, and is present if the tick has one. t
    is the direction of the tool's axis and d the desired one; rotation about the axis is free.
    K_o and `approach_speed_rad_s` replace K_e and `approach_speed_m_s`.

    Attributes:
        W_3: (m,), diagonal.

    Args:
        config: Weights and gains.
        vehicle: Gives the centre p_O of the learning space and the number of joints.
    """

    def __init__(self, config: Mpc, vehicle: VehicleModel):
        self._config, self._p_O = config, vehicle.p_O[:, None]
        joints = vehicle.per_joint(config.w_2_joints, "mpc.w_2_joints")
        self._W_2 = np.array([*config.w_2_base, *joints])
        joints = vehicle.per_joint(config.w_3_joints, "mpc.w_3_joints")
        self.W_3 = np.array([*config.w_3_base, *joints])
        self._is_base = np.arange(len(self._W_2)) < 3
        self._W_4 = np.array(config.w_4)
        self._position = TrackingTask(
            name="J_1",
            formula="| p_E' - p_Ed' + K_e e_E |^2 W_1",
            quantity="tool_position",
            rate="tool_velocity",
            gain=np.array(config.k_e),
            weight=np.array(config.w_1),
            speed=config.approach_speed_m_s,
        )
        self._pointing = TrackingTask(
            name="J_6",
            formula="| t' - d' + K_o (t - d) |^2 W_6",
            quantity="tool_axis",
            rate="tool_axis_rate",
            gain=np.full(3, config.k_o),
            weight=np.full(3, config.w_6),
            speed=config.approach_speed_rad_s,
        )
        self._I, self._I_v = np.eye(3), np.eye(len(self._W_2))
        self._at_rest = np.zeros((len(self._W_2), 1))

    def terms(self, tick: MpcInputs) -> list[CostTerm]:
        """Returns J_1, J_2, J_4 and, with an orientation task, J_6."""
        W_2 = self._W_2 * np.where(self._is_base, tick.w_q, tick.w_m)
        v_s = (("base_velocity", self._I_v[:, :3]), ("joint_velocity", self._I_v[:, 3:]))
        p_EB = ("tool_position_base", self._I)
        terms = [
            self._tracking(self._position, tick.end_effector.p_E, tick.reference),
            CostTerm("J_2", "| v_s |^2 W_2", v_s, self._at_rest, W_2),
            CostTerm("J_4", "| p_EB - p_O |^2 W_4", (p_EB,), self._p_O, self._W_4 * tick.w_d),
        ]
        if tick.pointing is not None:
            axis, reference = tick.pointing.axis.value, tick.pointing.reference
            terms.append(self._tracking(self._pointing, axis, reference))
        return terms

    def input_cost(self) -> CostTerm:
        """Returns J_3, whose u is the input during the stage."""
        u = ("input", self._I_v)
        return CostTerm("J_3", "| u |^2 W_3", (u,), self._at_rest, self.W_3)

    def _tracking(self, task: TrackingTask, value: np.ndarray, reference: np.ndarray) -> CostTerm:
        """Returns the term of a task whose quantity has the `value` (3,) now."""
        error = value - reference[0, :3]
        K, desired = limited_gain(task.gain, error, task.speed), reference[1:, 3:]
        parts: tuple[tuple[str, np.ndarray], ...] = ((task.rate, self._I),)
        if self._config.error == "predicted":
            parts, desired = (*parts, (task.quantity, np.diag(K))), desired + K * reference[1:, :3]
        else:
            desired = desired - K * error
        return CostTerm(task.name, task.formula, parts, desired.T, task.weight)


def stage_cost(terms: Sequence[CostTerm], predictions: StagePredictions) -> StageCost:
    """Returns the sum of terms, up to a constant."""
    C, c = 0.0, 0.0
    for term in terms:
        rows, offset = combined(term.parts, predictions)
        weighted = (term.weight[:, None] * rows).T
        C, c = C + weighted @ rows, c + weighted @ (offset - term.desired)
    return StageCost(C, c)


def combined(parts: Sequence[tuple[str, np.ndarray]], predictions: StagePredictions) -> Prediction:
    """Returns the prediction of sum_i M_i x_i.

    Args:
        parts: Name of the quantity x_i and M_i (d, size), of each i.
        predictions: Predictions of the tick.
    """
    rows, offset = 0.0, 0.0
    for quantity, M in parts:
        x = predictions[quantity]
        rows, offset = rows + M @ x.rows, offset + M @ x.offset
    return Prediction(rows, offset)


def limited_gain(gain: np.ndarray, error: np.ndarray, speed: float) -> np.ndarray:
    """Returns the gain (3,) 1/s, scaled down if it would correct `error` faster than `speed`.

    Args:
        gain: (3,) 1/s.
        error: (3,) m of a position, or 1 of a direction.
        speed: m/s, or rad/s.
    """
    return gain * min(1.0, speed / max(math.hypot(*(gain * error).tolist()), 1e-9))

"""What the tool carries along a reference, as least squares over the horizon."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.kinematics import Carried
from aerodrake.model.mpc_inputs import MpcInputs
from aerodrake.model.prediction import Prediction
from aerodrake.model.vehicle import GRAVITY
from aerodrake.scenario import Mpc


class Target(NamedTuple):
    """What y, carried by the tool, is to follow, and how closely.

    Attributes:
        y: Now, linearised.
        reference: (N + 1, 6), y_d and y_d' now and at each stage.
        gain: (3,) 1/s, K.
        weight: (3,), diagonal of W.
    """

    y: Carried
    reference: np.ndarray
    gain: np.ndarray
    weight: np.ndarray


class Tracking:
    """| y_k' - y_d,k' + K (y_k - y_d,k) |^2 W over the stages, times the ticks of each.

    y_k' = J_s s_k + J_yaw yaw' + J_u xi_u' with s_k = [p_B', q']; y_k moves with
    the same J_s. Roll and pitch are those of `config.tilt` as `MpcFormulation`
    has them, and so is `config.error` for y_k - y_d,k. y is the position of the
    end-effector, or the direction of its axis.

    Args:
        config: For `tilt` and `error`.
        prediction: Of the model, over the stages.
        scale: (N (3 + n),) inputs per unit of z, the unknowns of the program.
    """

    def __init__(
        self,
        config: Mpc,
        model: EquivalentModel,
        prediction: Prediction,
        stage_ticks: np.ndarray,
        scale: np.ndarray,
    ):
        self._config, self._model = config, model
        self._ticks = np.repeat(stage_ticks, 3)
        self._speeds = np.concatenate([model.base_velocity, model.joint_velocity])
        self._places = np.concatenate([model.base_position, model.joint_position])
        self._stage_s = model.dt * stage_ticks[:, None]
        # (N, 12 + 2 n, N m) per z: speeds, places, the acceleration that tilts the base, and
        # how fast it changes on the way to each stage.
        Gamma = prediction.Gamma * scale
        a = model.acceleration @ Gamma
        swing = np.diff(a, axis=0, prepend=0.0) / self._stage_s[:, :, None]
        self._Gamma = np.hstack([Gamma[:, self._speeds], Gamma[:, self._places], a, swing])

    def places(self, y: Carried) -> np.ndarray:
        """(3, nx), y per state: by J_s, and by the tilt that a base acceleration takes."""
        places = np.zeros((3, len(self._model.A)))
        places[:, self._places] = y.J_s
        if self._config.tilt == "flatness":
            places += tilt_matrix(y.r) @ self._model.acceleration
        return places

    def cost(
        self, target: Target, tick: MpcInputs, x_free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(rows over z, offset, weight): the sum of weight (rows z + offset)^2.

        Args:
            target: Of this tick.
            tick: For x_0 and the measured rates.
            x_free: (N, nx), the states under zero input.
        """
        config, model = self._config, self._model
        y, reference, K = target.y, target.reference, target.gain[:, None]
        T = tilt_matrix(y.r) if config.tilt == "flatness" else np.zeros((3, 3))
        is_predicted = config.error == "predicted"
        # y_k' + K y_k per [speeds, places, a, swing].
        rows = np.hstack([y.J_s, is_predicted * K * np.hstack([y.J_s, T]), T])

        a = np.vstack([tick.x_0, x_free]) @ model.acceleration.T
        swing = np.diff(a, axis=0) / self._stage_s
        moved = x_free[:, self._places] - tick.x_0[self._places]
        free = np.hstack([x_free[:, self._speeds], moved, a[1:] - a[0], swing])
        known = y.J_yaw * tick.yaw_rate
        if config.tilt == "held":
            known = known + y.J_u @ tick.xi_u_rates
        target_now = reference[1:, :3] if is_predicted else reference[0, :3]
        offset = free @ rows.T + known - reference[1:, 3:] + target.gain * (y.value - target_now)
        stacked = rows @ self._Gamma
        N = len(x_free)
        return stacked.reshape(3 * N, -1), offset.ravel(), np.tile(target.weight, N) * self._ticks


def limited_gain(gain: np.ndarray, error: np.ndarray, speed: float) -> np.ndarray:
    """(3,) 1/s, the gain scaled down where it would correct `error` faster than `speed`."""
    return gain * min(1.0, speed / max(np.linalg.norm(gain * error), 1e-9))


def tilt_matrix(r: np.ndarray) -> np.ndarray:
    """(3, 3) s^2, T: a base acceleration a tilts the base and so moves what it carries by T a.

    T = -[r]x [z]x / g, with r (3,) from the base to the end-effector in the world,
    or along its axis, for tilts small enough that the thrust stays near gravity's.
    """
    rx, ry, rz = r
    return np.array([[-rz, 0, 0], [0, -rz, 0], [rx, ry, 0]]) * (-1 / GRAVITY)

"""A prediction of the base's velocity over one period, and what came of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.compiled import compiled
from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.hidden_layers import HiddenLayers, infer_phi
from aerodrake.model.residual_features import features
from aerodrake.model.vehicle_state import parts


class VelocityModel(NamedTuple):
    """The equivalent model's rows of the base's velocity: v+ = A x + B u + gain * Delta.

    Attributes:
        A: (3, nx).
        B: (3, 3 + n).
        gain: (3,) c, the diagonal of its C in these rows.
    """

    A: np.ndarray
    B: np.ndarray
    gain: np.ndarray

    @classmethod
    def of(cls, model: EquivalentModel) -> VelocityModel:
        """Those of a model."""
        rows = model.base_velocity
        return cls(model.A[rows], model.B[rows], model.C[rows].diagonal().copy())


@compiled
def nominal_velocity(model: VelocityModel, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(3,) m/s, one period after x (nx,) under u (3 + n,), without Delta."""
    return model.A @ x + model.B @ u


@compiled
def residual_tick(
    layers: HiddenLayers,
    model: VelocityModel,
    pending: np.ndarray,
    state: np.ndarray,
    x_0: np.ndarray,
    base_setpoint: np.ndarray,
    joint_setpoint: np.ndarray,
    saturated: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Completes the prediction made a tick ago, and begins the next.

    Args:
        layers: Of the network.
        model: That predicts.
        pending: [is_one, x, phi, Delta] (1 + nx + h + 1 + 3,) of the tick before.
        state: (13 + 2 n,) measured.
        x_0: (nx,) state of the model.
        base_setpoint: (9,) [p_d, v_d, a_d]; a_d was applied since the tick before.
        joint_setpoint: (3 n,) [q_d, q_d', q_d''] alike.
        saturated: (1,).

    Returns:
        The next `pending`, whose Delta is still 0; not one, if anything here is not
        finite. And (6,) m/s, the error of the prediction pending, and what it would
        have been without Delta; they say nothing where none was.
    """
    u = np.concatenate((base_setpoint[6:], joint_setpoint[2 * len(joint_setpoint) // 3 :]))
    nx = len(x_0)
    v_B = parts(state)[4]
    errors = np.empty(6)
    errors[3:] = nominal_velocity(model, pending[1 : 1 + nx], u) - v_B
    errors[:3] = errors[3:] + model.gain * pending[-3:]
    seen = features(state, u)
    begun = np.zeros(len(pending))
    begun[1 : 1 + nx] = x_0
    begun[1 + nx : -3] = infer_phi(layers, seen)
    begun[0] = np.isfinite(begun).all() and np.isfinite(seen).all() and np.isfinite(saturated[0])
    return begun, errors

"""Inertia of the arm with a free base."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES
from aerodrake.support.compiled import compiled


class ArmInertia:
    """Inertia of the arm in any configuration, with a free base: torque over acceleration.

    Args:
        plant: The robot's nominal plant, `VehicleModel.plant`.
    """

    def __init__(self, plant: MultibodyPlant):
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        self._positions = plant.GetPositions(self._context)

    def at(self, q: np.ndarray) -> np.ndarray:
        """Returns M_qq - M_qb M_bb^-1 M_bq (n, n) kg m^2 for q (n,) rad."""
        self._positions[BASE_POSITIONS:] = q
        self._plant.SetPositions(self._context, self._positions)
        return reduced_inertia(self._plant.CalcMassMatrix(self._context))


@compiled
def reduced_inertia(M: np.ndarray) -> np.ndarray:
    """Returns M_qq - M_qb M_bb^-1 M_bq (n, n) for the mass matrix M (6 + n, 6 + n)."""
    b = BASE_VELOCITIES
    M_bb, M_bq = M[:b, :b].copy(), M[:b, b:].copy()
    return M[b:, b:] - M_bq.T @ np.linalg.solve(M_bb, M_bq)

"""Inverse dynamics of base and arm together."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from aerodrake.model.vehicle import add_robot


class WholeBody:
    """M(q) v' + C(q, v) v - tau_g(q), of the robot as its URDF has it.

    Args:
        robot: A `package://aerodrake/...` URI, or the path of a URDF.
    """

    def __init__(self, robot: str):
        self._plant = MultibodyPlant(0.0)
        add_robot(self._plant, robot)
        self._plant.Finalize()
        self._context = self._plant.CreateDefaultContext()
        self._gravity = MultibodyForces(self._plant)  # And the joints' damping.

    def effort(self, x: np.ndarray, vdot: np.ndarray) -> np.ndarray:
        """(6 + n,), what it takes to give base and joints these accelerations.

        Args:
            x: (13 + 2 n,) where they are, and how fast, as `VehicleState` has it.
            vdot: (6 + n,) rad/s^2 and m/s^2 of the base, of its origin, in the world;
                rad/s^2 of the joints.

        Returns:
            N m about the base's origin and N, in the world; N m of the joints.
        """
        plant, context = self._plant, self._context
        plant.SetPositionsAndVelocities(context, x)
        plant.CalcForceElementsContribution(context, self._gravity)
        return plant.CalcInverseDynamics(context, vdot, self._gravity)

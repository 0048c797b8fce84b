"""Inverse dynamics of base and arm together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from aerodrake.model.vehicle import add_robot
from aerodrake.model.vehicle_state import VehicleState


@dataclass(frozen=True)
class Effort:
    """What a motion takes.

    Attributes:
        force: (3,) N, on the base's origin, in the world.
        torque: (3,) N m, about it, in the base frame.
        joint_torque: (n,) N m.
    """

    force: np.ndarray
    torque: np.ndarray
    joint_torque: np.ndarray


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

    def effort(self, state: VehicleState, a_B: np.ndarray, qddot: np.ndarray) -> Effort:
        """What it takes to give base and joints these accelerations, without turning the base.

        Args:
            state: Where they are, and how fast.
            a_B: (3,) m/s^2, of the base's origin in the world.
            qddot: (n,) rad/s^2.
        """
        plant, context = self._plant, self._context
        plant.SetPositionsAndVelocities(context, state.to_vector())
        gravity = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, gravity)
        forces = plant.CalcInverseDynamics(
            context, np.concatenate([np.zeros(3), a_B, qddot]), gravity
        )
        return Effort(forces[3:6], state.R_B.T @ forces[:3], forces[6:])

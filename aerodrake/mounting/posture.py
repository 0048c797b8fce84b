"""Posture of an arm below its base: tool, Jacobians, torques and links at joint angles."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.robot import BASE_FRAME
from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES
from aerodrake.model.vehicle.vehicle import GRAVITY


class Posture(NamedTuple):
    """Geometry and statics of an arm in hover, in the base frame.

    Attributes:
        tool: (3,) m, position of the tool.
        axis: (3,) direction in which it points.
        jacobian: (3, n) m/rad, of the position.
        axis_jacobian: (3, n) 1/rad, of the direction.
        torque: (n,) N m, torques that hold the arm.
        offset: (2,) m, horizontal offset of the arm's centre of mass.
        highest: m, height of the highest origin of a link that moves.
    """

    tool: np.ndarray
    axis: np.ndarray
    jacobian: np.ndarray
    axis_jacobian: np.ndarray
    torque: np.ndarray
    offset: np.ndarray
    highest: float


class Postures:
    """Evaluation of postures of a vehicle's arm, with its base level and at rest.

    Attributes:
        lower, upper: (n,) rad, limits of the joints.
        effort: (n,) N m, limits of their torques.
        mass: kg, of the arm.

    Args:
        plant: Finalised plant of the vehicle alone.
    """

    def __init__(self, plant: MultibodyPlant):
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        self._positions = plant.GetDefaultPositions()
        self._kinematics = Kinematics(plant)
        self._base = plant.GetFrameByName(BASE_FRAME)
        indices = plant.GetBodyIndices(self._base.model_instance())
        self._arm = [i for i in indices if i != self._base.body().index()]
        bodies = map(plant.get_body, self._arm)
        still = plant.GetBodiesWeldedTo(self._base.body())
        self._moving = [body.body_frame() for body in bodies if body not in still]
        self.lower = plant.GetPositionLowerLimits()[BASE_POSITIONS:]
        self.upper = plant.GetPositionUpperLimits()[BASE_POSITIONS:]
        self.effort = plant.GetEffortUpperLimits()
        self.mass = plant.CalcTotalMass(self._context) - self._base.body().default_mass()

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Returns the plant's positions (7 + n,) at joint angles q (n,) rad."""
        return np.concatenate((self._positions[:BASE_POSITIONS], q))

    def at(self, q: np.ndarray) -> Posture:
        """Returns the posture at joint angles q (n,) rad."""
        plant, context, base, origin = self._plant, self._context, self._base, np.zeros(3)
        plant.SetPositions(context, self.positions(q))
        tool, jacobian = self._kinematics.arm(q)
        axis, axis_jacobian = self._kinematics.arm_axis(q)
        gravity = plant.CalcGravityGeneralizedForces(context)
        return Posture(
            tool=tool,
            axis=axis,
            jacobian=jacobian,
            axis_jacobian=axis_jacobian,
            torque=-gravity[BASE_VELOCITIES:],
            # The moment of the arm's weight about the base's origin is r x m g.
            offset=np.array([gravity[1], -gravity[0]]) / (self.mass * GRAVITY),
            highest=max(
                plant.CalcPointsPositions(context, frame, origin, base)[2, 0]
                for frame in self._moving
            ),
        )

    def inertia(self, q: np.ndarray) -> float:
        """Returns the arm's largest moment about a horizontal axis through the base's origin.

        It is in kg m^2, at joint angles q (n,) rad.
        """
        self._plant.SetPositions(self._context, self.positions(q))
        spatial = self._plant.CalcSpatialInertia(self._context, self._base, self._arm)
        moments = spatial.CalcRotationalInertia().CopyToFullMatrix3()[:2, :2]
        return float(np.linalg.eigvalsh(moments)[-1])

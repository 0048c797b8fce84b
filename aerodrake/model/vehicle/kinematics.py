"""Kinematics of the end-effector and of the tool's axis: positions, Jacobians and reach."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform, VectorToSkewSymmetric
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from scipy.optimize import minimize

from aerodrake.model.vehicle.robot import BASE_FRAME, TOOL_AXIS, TOOL_FRAME
from aerodrake.model.vehicle.rotation import cross
from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES, VehicleState
from aerodrake.support.compiled import compiled

REACH_STARTS = 32
"""Number of random start configurations of the search for the farthest reach."""


@dataclass(frozen=True)
class TaskVector:
    """Position or direction fixed to the tool, in the world, and its Jacobians.

    Attributes:
        r: (3,), its part that rotates with the base.
        J_c: (3, 4 + n), Jacobian with respect to xi_c = [p_B, yaw, q] (paper, eq. 2).
        J_u: (3, 2), Jacobian with respect to xi_u = [roll, pitch] (paper, eq. 2).
    """

    r: np.ndarray
    J_c: np.ndarray
    J_u: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """(3,), the vector itself."""
        return self.r

    @cached_property
    def J_s(self) -> np.ndarray:
        """(3, 3 + n), the columns of J_c for the MPC's inputs, [p_B, q]."""
        return np.delete(self.J_c, 3, axis=1)

    @property
    def J_yaw(self) -> np.ndarray:
        """(3,), the column of J_c for yaw."""
        return self.J_c[:, 3]


@dataclass(frozen=True)
class ToolAxis(TaskVector):
    """Direction of the tool's axis, a unit vector equal to r."""


@dataclass(frozen=True)
class EndEffector(TaskVector):
    """Position of the end-effector; r, in m, is R_B p_EB, from the base's origin to it.

    Attributes:
        p_E: (3,) m, position in the world: p_B + R_B p_EB (paper, eq. 1).
        p_EB: (3,) m, position in the base frame.
        J_B: (3, n) m/rad, Jacobian of p_EB with respect to q.
    """

    p_E: np.ndarray
    p_EB: np.ndarray
    J_B: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """(3,) m, p_E."""
        return self.p_E


class Kinematics:
    """Forward kinematics and Jacobians of the arm, from the robot's nominal plant.

    Args:
        plant: The robot's nominal plant, `VehicleModel.plant`.
    """

    def __init__(self, plant: MultibodyPlant):
        self._plant = plant
        self._base = plant.GetFrameByName(BASE_FRAME)
        self._tool = plant.GetFrameByName(TOOL_FRAME)
        self._context = plant.CreateDefaultContext()
        self._positions = plant.GetDefaultPositions()

    def tool(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns position p_EB (3,) m and axis t (3,) of the tool in the base frame, at joint
        angles q (n,) rad."""
        X_BE = self.tool_pose(q)
        return X_BE.translation(), X_BE.rotation().multiply(TOOL_AXIS)

    def tool_pose(self, q: np.ndarray) -> RigidTransform:
        """Returns the pose of the frame `tool` in the base frame, at joint angles q (n,) rad."""
        self._set(q)
        return self._plant.CalcRelativeTransform(self._context, self._base, self._tool)

    def arm(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns p_EB (3,) m and its Jacobian J_B (3, n) m/rad in the base frame, at joint angles
        q (n,) rad."""
        plant, origin = self._plant, np.zeros(3)
        self._set(q)
        p_EB = plant.CalcPointsPositions(self._context, self._tool, origin, self._base)[:, 0]
        J = plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kV, self._tool, origin, self._base, self._base
        )
        return p_EB, J[:, BASE_VELOCITIES:]

    def arm_axis(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the tool's axis t (3,) and its Jacobian (3, n) 1/rad in the base frame, at joint
        angles q (n,) rad."""
        _, t = self.tool(q)
        J_omega = self._plant.CalcJacobianAngularVelocity(
            self._context, JacobianWrtVariable.kV, self._tool, self._base, self._base
        )[:, BASE_VELOCITIES:]
        return t, -VectorToSkewSymmetric(t) @ J_omega

    def _set(self, q: np.ndarray) -> None:
        self._positions[BASE_POSITIONS:] = q
        self._plant.SetPositions(self._context, self._positions)

    def end_effector(self, state: VehicleState) -> EndEffector:
        """Returns the position of the end-effector and its Jacobians at `state`."""
        p_EB, J_B = self.arm(state.q)
        r, J_c, J_u = task_vector(state.R_B, p_EB, J_B, moves=True)
        return EndEffector(r=r, J_c=J_c, J_u=J_u, p_E=state.p_B + r, p_EB=p_EB, J_B=J_B)

    def tool_axis(self, state: VehicleState) -> ToolAxis:
        """Returns the direction of the tool's axis and its Jacobians at `state`."""
        t_B, J_B = self.arm_axis(state.q)
        t, J_c, J_u = task_vector(state.R_B, t_B, J_B, moves=False)
        return ToolAxis(r=t, J_c=J_c, J_u=J_u)

    def farthest_reach(self, p_O: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
        """Returns the largest distance in m of the end-effector from p_O within joint limits.

        This is the URDF's value of the paper's d_edge, found by local searches from random
        configurations, which are the same at every call.

        Args:
            p_O: (3,) m, a point in the base frame.
            lower, upper: (n,) rad, joint limits.
        """

        def negative_square(q: np.ndarray) -> tuple[float, np.ndarray]:
            p_EB, J_B = self.arm(q)
            offset = p_EB - p_O
            return -offset @ offset / 2, -J_B.T @ offset

        spread = np.random.default_rng(0).random((REACH_STARTS, len(lower)))
        bounds = list(zip(lower, upper, strict=True))
        minima = [
            minimize(negative_square, q, jac=True, bounds=bounds, method="L-BFGS-B").fun
            for q in lower + spread * (upper - lower)
        ]
        return float(np.sqrt(-2 * min(minima)))


@compiled
def task_vector(
    R_B: np.ndarray, p: np.ndarray, J_B: np.ndarray, moves: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns r (3,), J_c (3, 4 + n) and J_u (3, 2) of a `TaskVector`.

    Args:
        R_B: (3, 3) rotation from the base to the world frame.
        p: (3,) position or direction in the base frame.
        J_B: (3, n) Jacobian of p with respect to q, in the base frame.
        moves: True for positions, which translate with the base; False for directions.
    """
    n = J_B.shape[1]
    r = np.zeros(3)
    J_c, J_u = np.zeros((3, 4 + n)), np.empty((3, 2))
    for i in range(3):
        J_c[i, i] = 1.0 if moves else 0.0
        for j in range(3):
            r[i] += R_B[i, j] * p[j]
            for k in range(n):
                J_c[i, 4 + k] += R_B[i, j] * J_B[j, k]
    # Axes of roll, pitch and yaw: the base's x axis, the level axis to its left, and up.
    level = np.sqrt(R_B[0, 0] * R_B[0, 0] + R_B[1, 0] * R_B[1, 0])
    left = np.array([-R_B[1, 0] / level, R_B[0, 0] / level, 0.0])
    J_u[:, 0], J_u[:, 1] = cross(np.ascontiguousarray(R_B[:, 0]), r), cross(left, r)
    J_c[:, 3] = np.array([-r[1], r[0], 0.0])
    return r, J_c, J_u

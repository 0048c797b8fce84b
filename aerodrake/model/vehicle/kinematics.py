"""Where the end-effector is and how it moves with base and joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import VectorToSkewSymmetric
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from aerodrake.model.vehicle.rotation import cross
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import BASE_FRAME, TOOL_AXIS, TOOL_FRAME, add_robot
from aerodrake.support.compiled import compiled


@dataclass(frozen=True)
class TaskVector:
    """A vector in the world that the tool carries, and how it moves with base and joints.

    Attributes:
        r: (3,), the part of it that turns with the base.
        J_c: (3, 4 + n), its derivative per xi_c' = [p_B', yaw', q'] (paper, eq. 2).
        J_u: (3, 2), its derivative per xi_u' = [roll', pitch'] (paper, eq. 2).
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
        """(3, 3 + n), the columns of J_c that the MPC commands: [p_B', q']."""
        return np.delete(self.J_c, 3, axis=1)

    @property
    def J_yaw(self) -> np.ndarray:
        """(3,), the column of J_c that belongs to the yaw rate."""
        return self.J_c[:, 3]


@dataclass(frozen=True)
class ToolAxis(TaskVector):
    """The direction of the tool's axis, a unit vector; r is the whole of it."""


@dataclass(frozen=True)
class EndEffector(TaskVector):
    """The position of the end-effector; r, in m, is R_B p_EB, from the base to it.

    Attributes:
        p_E: (3,) m, position in the world: p_B + R_B p_EB (paper, eq. 1).
        p_EB: (3,) m, position in the base frame.
        J_B: (3, n), p_EB' per q', in the base frame.
    """

    p_E: np.ndarray
    p_EB: np.ndarray
    J_B: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """(3,) m, p_E."""
        return self.p_E


class Kinematics:
    """Forward kinematics and Jacobians, with the arm's chain from the URDF.

    Args:
        robot: A `package://aerodrake/...` URI, or the path of a URDF.
    """

    def __init__(self, robot: str):
        self._plant = MultibodyPlant(0.0)
        add_robot(self._plant, robot)
        base = self._plant.GetFrameByName(BASE_FRAME)
        self._plant.WeldFrames(self._plant.world_frame(), base)
        self._plant.Finalize()
        self._context = self._plant.CreateDefaultContext()
        self._tool = self._plant.GetFrameByName(TOOL_FRAME)

    def tool(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(p_EB (3,) m, t (3,)) in the base frame at q (n,) rad: where the tool is, and points."""
        self._plant.SetPositions(self._context, q)
        X_BE = self._tool.CalcPoseInWorld(self._context)  # The base is the world here.
        return X_BE.translation(), X_BE.rotation().multiply(TOOL_AXIS)

    def arm(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(p_EB (3,) m, J_B (3, n)) in the base frame at joint angles q (n,) rad."""
        plant, world = self._plant, self._plant.world_frame()
        plant.SetPositions(self._context, q)
        p_EB = plant.CalcPointsPositions(self._context, self._tool, np.zeros(3), world)[:, 0]
        J_B = plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kQDot, self._tool, np.zeros(3), world, world
        )
        return p_EB, J_B

    def arm_axis(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(t (3,), its Jacobian (3, n)) in the base frame, of the tool's axis at q (n,) rad."""
        plant, world = self._plant, self._plant.world_frame()
        plant.SetPositions(self._context, q)
        t = self._tool.CalcRotationMatrixInWorld(self._context).multiply(TOOL_AXIS)
        J_omega = plant.CalcJacobianAngularVelocity(
            self._context, JacobianWrtVariable.kQDot, self._tool, world, world
        )
        return t, -VectorToSkewSymmetric(t) @ J_omega

    def end_effector(self, state: VehicleState) -> EndEffector:
        """Position of the end-effector at `state`."""
        p_EB, J_B = self.arm(state.q)
        r, J_c, J_u = task_vector(state.R_B, p_EB, J_B, moves=True)
        return EndEffector(r=r, J_c=J_c, J_u=J_u, p_E=state.p_B + r, p_EB=p_EB, J_B=J_B)

    def tool_axis(self, state: VehicleState) -> ToolAxis:
        """Direction of the tool's axis at `state`."""
        t_B, J_B = self.arm_axis(state.q)
        t, J_c, J_u = task_vector(state.R_B, t_B, J_B, moves=False)
        return ToolAxis(r=t, J_c=J_c, J_u=J_u)


@compiled
def task_vector(
    R_B: np.ndarray, p: np.ndarray, J_B: np.ndarray, moves: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(r (3,), J_c (3, 4 + n), J_u (3, 2)) as `TaskVector` has them, of what the arm carries.

    Args:
        R_B: (3, 3).
        p: (3,), in the base frame.
        J_B: (3, n), p' per q', in the base frame.
        moves: Whether it moves with the base, as places do and directions do not.
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
    # The axes about which roll, pitch and yaw turn the base: its own x, that level and to
    # the left of it, and up.
    level = np.sqrt(R_B[0, 0] * R_B[0, 0] + R_B[1, 0] * R_B[1, 0])
    left = np.array([-R_B[1, 0] / level, R_B[0, 0] / level, 0.0])
    J_u[:, 0], J_u[:, 1] = cross(np.ascontiguousarray(R_B[:, 0]), r), cross(left, r)
    J_c[:, 3] = np.array([-r[1], r[0], 0.0])
    return r, J_c, J_u

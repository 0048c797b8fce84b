"""Where the end-effector is and how it moves with base and joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix, VectorToSkewSymmetric
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from aerodrake.model.vehicle import BASE_FRAME, TOOL_AXIS, TOOL_FRAME, add_robot
from aerodrake.model.vehicle_state import VehicleState


@dataclass(frozen=True)
class Carried:
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
class ToolAxis(Carried):
    """The direction of the tool's axis, a unit vector; r is the whole of it."""


@dataclass(frozen=True)
class EndEffector(Carried):
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
        """(t (3,), its Jacobian (3, n)) in the base frame: direction of the tool's axis at q."""
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
        R_B = state.R_B
        r = R_B @ p_EB
        J_yaw, J_u = _turning(R_B, r)
        J_c = np.column_stack([np.eye(3), J_yaw, R_B @ J_B])
        return EndEffector(r=r, J_c=J_c, J_u=J_u, p_E=state.p_B + r, p_EB=p_EB, J_B=J_B)

    def tool_axis(self, state: VehicleState) -> ToolAxis:
        """Direction of the tool's axis at `state`."""
        t_B, J_B = self.arm_axis(state.q)
        R_B = state.R_B
        t = R_B @ t_B
        J_yaw, J_u = _turning(R_B, t)
        return ToolAxis(r=t, J_c=np.column_stack([np.zeros((3, 3)), J_yaw, R_B @ J_B]), J_u=J_u)


def _turning(R_B: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(r' per yaw' (3,), r' per [roll', pitch'] (3, 2)) of an r (3,) that turns with the base."""
    _, pitch, yaw = RollPitchYaw(RotationMatrix(R_B)).vector()
    # The axes about which roll, pitch and yaw turn the base, in the world.
    axis_roll = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
    axis_pitch = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    axis_yaw = np.array([0.0, 0.0, 1.0])
    turned = -VectorToSkewSymmetric(r) @ np.column_stack([axis_roll, axis_pitch, axis_yaw])
    return turned[:, 2], turned[:, :2]

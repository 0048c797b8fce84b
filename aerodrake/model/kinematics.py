"""Where the end-effector is and how it moves with base and joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix, VectorToSkewSymmetric
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from aerodrake.model.vehicle import BASE_FRAME, TOOL_FRAME, add_robot
from aerodrake.model.vehicle_state import VehicleState


@dataclass(frozen=True)
class EndEffector:
    """Kinematics of the end-effector at one state.

    Attributes:
        p_E: (3,) m, position in the world: p_B + R_B p_EB (paper, eq. 1).
        p_EB: (3,) m, position in the base frame.
        r: (3,) m, R_B p_EB: from the base to the end-effector, in the world.
        J_c: (3, 4 + n), p_E' per xi_c' = [p_B', yaw', q'] (paper, eq. 2).
        J_u: (3, 2), p_E' per xi_u' = [roll', pitch'] (paper, eq. 2).
        J_B: (3, n), p_EB' per q', in the base frame.
    """

    p_E: np.ndarray
    p_EB: np.ndarray
    r: np.ndarray
    J_c: np.ndarray
    J_u: np.ndarray
    J_B: np.ndarray

    @property
    def J_s(self) -> np.ndarray:
        """(3, 3 + n), the columns of J_c that the MPC commands: [p_B', q']."""
        return np.delete(self.J_c, 3, axis=1)

    @property
    def J_yaw(self) -> np.ndarray:
        """(3,), the column of J_c that belongs to the yaw rate."""
        return self.J_c[:, 3]


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

    def end_effector(self, state: VehicleState) -> EndEffector:
        """Kinematics of the end-effector at `state`."""
        p_EB, J_B = self.arm(state.q)
        R_B = state.R_B
        r = R_B @ p_EB
        _, pitch, yaw = RollPitchYaw(RotationMatrix(R_B)).vector()
        # The axes about which roll, pitch and yaw turn the base, in the world.
        axis_roll = np.array(
            [np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)]
        )
        axis_pitch = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        axis_yaw = np.array([0.0, 0.0, 1.0])
        turned = -VectorToSkewSymmetric(r) @ np.column_stack([axis_roll, axis_pitch, axis_yaw])
        J_c = np.column_stack([np.eye(3), turned[:, 2], R_B @ J_B])
        J_u = turned[:, :2]
        return EndEffector(state.p_B + r, p_EB, r, J_c, J_u, J_B)

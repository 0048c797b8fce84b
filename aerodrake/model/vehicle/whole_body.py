"""What it takes to move base and arm."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from aerodrake.model.vehicle.rotation import UP, cross, rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY, add_robot
from aerodrake.support.compiled import compiled


class WholeBody:
    """Inverse dynamics, M(q) v' + C(q, v) v - tau_g(q), of the robot as its URDF has it.

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

    def momentum(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the spatial momentum about the centre of mass, and r_BC, in the world frame.

        (6,) angular momentum, N m s, and linear momentum, N s; and (3,) m, from the base's
        origin to the centre of mass.

        Args:
            x: (13 + 2 n,) where base and joints are, and how fast.
        """
        plant, context = self._plant, self._context
        plant.SetPositionsAndVelocities(context, x)
        p_C = plant.CalcCenterOfMassPositionInWorld(context)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, p_C)
        r_BC = p_C - split_state(x)[1]
        return momentum.get_coeffs(), r_BC


@compiled
def commanded_motion(
    state: np.ndarray, joint_setpoint: np.ndarray, a_B: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The state (13 + 2 n,) with the arm as commanded, and v' (6 + n,) with no turn of the base.

    The commanded arm, since the measured one is noisier than its lag is long.

    Args:
        state: (13 + 2 n,) measured.
        joint_setpoint: (3 n,) q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        a_B: (3,) m/s^2, of the base's origin in the world.
    """
    n = len(joint_setpoint) // 3
    q_d, qdot_d, qddot_d = joint_setpoint[:n], joint_setpoint[n : 2 * n], joint_setpoint[2 * n :]
    quaternion, p_B, _, omega_W, v_B, _ = split_state(state)
    x = np.concatenate((quaternion, p_B, q_d, omega_W, v_B, qdot_d))
    return x, np.concatenate((np.zeros(3), a_B, qddot_d))


@compiled
def rigid_body_effort(
    mass: float, inertia: np.ndarray, state: np.ndarray, a_B: np.ndarray
) -> np.ndarray:
    """(6,) what `WholeBody.effort` says of the base, for a rigid body with its mass at the origin.

    Args:
        mass: kg.
        inertia: (3, 3) kg m^2 in the base frame.
        state: (13 + 2 n,) measured.
        a_B: (3,) m/s^2, of the base's origin in the world.
    """
    quaternion, _, _, omega_W, _, _ = split_state(state)
    R = rotation_matrix(quaternion)
    omega = R.T @ omega_W
    torque = cross(omega, inertia @ omega)
    return np.concatenate((R @ torque, mass * (a_B + GRAVITY * UP)))

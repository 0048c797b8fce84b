"""Whole-body inverse dynamics and momentum."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from aerodrake.model.vehicle.rotation import UP, cross, rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


class WholeBody:
    """Dynamics of the nominal robot: M(q) v' + C(q, v) v - tau_g(q).

    Args:
        plant: The robot's nominal plant, `VehicleModel.plant`.
    """

    def __init__(self, plant: MultibodyPlant):
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        self._gravity = MultibodyForces(plant)  # And the joints' damping.
        self._mass = plant.CalcTotalMass(self._context)

    def effort(self, x: np.ndarray, vdot: np.ndarray) -> np.ndarray:
        """Returns the generalized force (6 + n,) for given accelerations: inverse dynamics.

        Args:
            x: (13 + 2 n,) state of the vehicle.
            vdot: (6 + n,) rad/s^2 and m/s^2 of the base, of its origin, in the world;
                rad/s^2 of the joints.

        Returns:
            N m about the base's origin and N, in the world; N m of the joints.
        """
        plant, context = self._plant, self._context
        plant.SetPositionsAndVelocities(context, x)
        plant.CalcForceElementsContribution(context, self._gravity)
        return plant.CalcInverseDynamics(context, vdot, self._gravity)

    def centre_acceleration(self, x: np.ndarray, vdot: np.ndarray) -> np.ndarray:
        """Returns the acceleration (3,) m/s^2 of the centre of mass, in the world.

        Args:
            x: (13 + 2 n,) state of the vehicle.
            vdot: (6 + n,) accelerations, as for `effort`.
        """
        return self.effort(x, vdot)[3:6] / self._mass - GRAVITY * UP

    def momentum(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the momentum about the centre of mass, and the centre of mass, in the world.

        Args:
            x: (13 + 2 n,) state of the vehicle.

        Returns:
            (6,) angular momentum in N m s and linear momentum in N s; (3,) m, r_BC, from the base's
            origin to the centre of mass.
        """
        plant, context = self._plant, self._context
        plant.SetPositionsAndVelocities(context, x)
        p_C = plant.CalcCenterOfMassPositionInWorld(context)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, p_C)
        return momentum.get_coeffs(), p_C - split_state(x).p_B


@compiled
def commanded_motion(
    state: np.ndarray, joint_setpoint: np.ndarray, a_B: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the state (13 + 2 n,) with the arm at its setpoint, and v' (6 + n,) with no angular
    acceleration of the base.

    The arm's setpoint is used, since noise of the measured arm exceeds its tracking error.

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
    """Returns the base's part (6,) of `WholeBody.effort` for a rigid body with its centre of mass
    at the base's origin.

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

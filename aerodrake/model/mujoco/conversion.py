"""Conversion between the vehicle's state and forces, and those of MuJoCo.

MuJoCo has the base's position before its quaternion, and its linear velocity, in the world, before
its angular velocity, in the base frame.
"""

import numpy as np

from aerodrake.model.vehicle.rotation import apply, rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.support.compiled import compiled


@compiled
def write_positions_and_velocities(x: np.ndarray, qpos: np.ndarray, qvel: np.ndarray) -> None:
    """Converts a state for MuJoCo.

    Args:
        x: (13 + 2 n,) `VehicleState`.
        qpos: (7 + n,) m, quaternion and rad, written.
        qvel: (6 + n,) m/s and rad/s, written.
    """
    quaternion, p_B, q, omega_W, v_B, qdot = split_state(x)
    qpos[:3], qpos[3:7], qpos[7:] = p_B, quaternion, q
    qvel[:3], qvel[3:6], qvel[6:] = v_B, apply(rotation_matrix(quaternion).T, omega_W), qdot


@compiled
def state_of(qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """Returns the state (13 + 2 n,), a `VehicleState`, of MuJoCo's positions and velocities.

    Args:
        qpos: (7 + n,) m, quaternion and rad.
        qvel: (6 + n,) m/s and rad/s.
    """
    x = np.empty(len(qpos) + len(qvel))
    quaternion, p_B, q, omega_W, v_B, qdot = split_state(x)
    quaternion[:], p_B[:], q[:] = qpos[3:7], qpos[:3], qpos[7:]
    omega_W[:], v_B[:], qdot[:] = apply(rotation_matrix(quaternion), qvel[3:6]), qvel[:3], qvel[6:]
    return x


@compiled
def write_forces(
    thrust: np.ndarray,
    torque: np.ndarray,
    force: np.ndarray,
    ctrl: np.ndarray,
    qfrc: np.ndarray,
    wrench: np.ndarray,
) -> None:
    """Converts forces for MuJoCo.

    The base's torque is a Cartesian one, since a generalized one of MuJoCo turns with the base
    during a step.

    Args:
        thrust: (k,) N, of the rotors.
        torque: (n,) N m, of the joints.
        force: (6 + n,) generalized force on [omega_W, v_B, q'].
        ctrl: (k,) N, controls of the rotors, written.
        qfrc: (6 + n,) N, N m and N m, MuJoCo's generalized force, written.
        wrench: (6,) N and N m on the base in the world, of which the torque is written.
    """
    ctrl[:] = thrust
    wrench[3:] = force[:3]
    qfrc[:3] = force[3:6]
    qfrc[6:] = torque + force[6:]
    if not np.all(np.isfinite(thrust)):  # MuJoCo replaces such controls by zeros.
        qfrc[:3] = np.nan

"""Steps of the vehicle's dynamics in MuJoCo."""

import logging
from collections.abc import Sequence
from copy import copy

import mujoco
import numpy as np
from mujoco import MjData, MjModel, mjtIntegrator
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from aerodrake.model.mujoco.conversion import (
    state_of,
    write_forces,
    write_positions_and_velocities,
)

INTEGRATORS = {
    "rk4": mjtIntegrator.mjINT_RK4,
    "euler": mjtIntegrator.mjINT_EULER,
    "implicitfast": mjtIntegrator.mjINT_IMPLICITFAST,
}
"""Integrators by the names of `physics.integrator`."""

# By default MuJoCo prints its warnings, and writes them into a file in the working directory.
mujoco.set_mju_user_warning(logging.getLogger("mujoco").info)


class MujocoEngine:
    """Dynamics of a vehicle in MuJoCo: the state after a step, and poses of the bodies.

    Results depend on the arguments alone; `data` is memory for intermediate results.

    Forces are constant during a step, in the frames in which they act: rotor thrusts and their
    drag torques turn with the base, the generalized force on the base is fixed in the world. Each
    stage of a Runge-Kutta step has the base's attitude of its own.

    Attributes:
        model: The vehicle, with time step and integrator.
        data: Positions, velocities and forces of the last call, and its intermediate results.

    Args:
        model: The vehicle, of `make_mujoco_model`; copied.
        period: s, duration of a step.
        integrator: A name in `INTEGRATORS`.
        substeps: Number of MuJoCo's time steps in a step.
    """

    def __init__(self, model: MjModel, period: float, integrator: str, substeps: int = 1):
        self.model, self._substeps = copy(model), substeps
        self.model.opt.timestep = period / substeps
        self.model.opt.integrator = INTEGRATORS[integrator]
        self.data = MjData(self.model)
        self._qpos, self._qvel = self.data.qpos, self.data.qvel
        self._control, self._generalized = self.data.ctrl, self.data.qfrc_applied
        self._wrench = self.data.xfrc_applied[model.jnt_bodyid[0]]  # The first joint is free.

    def step(
        self, x: np.ndarray, thrust: np.ndarray, torque: np.ndarray, force: np.ndarray
    ) -> np.ndarray:
        """Returns the state (13 + 2 n,) after a step; not finite if an argument is not.

        Args:
            x: (13 + 2 n,) `VehicleState`.
            thrust: (k,) N, of the rotors.
            torque: (n,) N m, of the joints.
            force: (6 + n,) generalized force on [omega_W, v_B, q'].
        """
        self.write(x, thrust, torque, force)
        self.advance(self._substeps)
        return state_of(self._qpos, self._qvel)

    def advance(self, steps: int) -> None:
        """Advances `data` by some of MuJoCo's time steps, with the forces in it."""
        mujoco.mj_step(self.model, self.data, steps)

    def write(
        self, x: np.ndarray, thrust: np.ndarray, torque: np.ndarray, force: np.ndarray
    ) -> None:
        """Writes arguments into `data` as `step` does.

        Args:
            x: (13 + 2 n,) `VehicleState`.
            thrust: (k,) N.
            torque: (n,) N m.
            force: (6 + n,) generalized force on [omega_W, v_B, q'].
        """
        write_positions_and_velocities(x, self._qpos, self._qvel)
        write_forces(thrust, torque, force, self._control, self._generalized, self._wrench)

    def body_poses(self, x: np.ndarray, bodies: Sequence[int]) -> list[RigidTransform]:
        """Returns the poses of bodies in the world.

        Args:
            x: (13 + 2 n,) `VehicleState`.
            bodies: Numbers of the bodies.
        """
        write_positions_and_velocities(x, self._qpos, self._qvel)
        mujoco.mj_kinematics(self.model, self.data)
        return [
            RigidTransform(Quaternion(self.data.xquat[i]), self.data.xpos[i].copy()) for i in bodies
        ]

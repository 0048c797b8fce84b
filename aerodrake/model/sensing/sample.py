"""Samples of the vehicle's state, their groups, and the noise on them."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import (
    apply,
    length,
    product,
    quaternion_of,
    rotation_matrix,
    turned,
)
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Sensors
from aerodrake.support.compiled import compiled

GROUPS = ("position", "attitude", "joints")
"""Parts of a sample by sensor: p_B and v_B; quaternion and omega_W; q and q'."""

POSITION, ATTITUDE, JOINTS = range(3)
"""Indices of the groups."""


ACCELEROMETER, TOOL = 3, 4
"""Indices of the other sensors, after the groups."""

INERTIAL_NOISE = 9
"""Number of normal draws of the inertial sensors for one sample."""


class InertialNoise(NamedTuple):
    """Standard normal draws for the inertial sensors.

    Attributes:
        rate_walk: (3,) random walk of the gyroscope's bias.
        accelerometer: (3,) noise of the accelerometer.
        accelerometer_walk: (3,) random walk of its bias.
    """

    rate_walk: np.ndarray
    accelerometer: np.ndarray
    accelerometer_walk: np.ndarray


def split_inertial_noise(noise: np.ndarray) -> InertialNoise:
    """Returns the parts of draws `noise` (9,) as views."""
    return InertialNoise(noise[:3], noise[3:6], noise[6:])


class Sample(NamedTuple):
    """One sample of the vehicle's state.

    Attributes:
        state: (13 + 2 n,) as measured.
        stamps: (3,) s, the time at which each group was sampled; a sensor delay is not included.
    """

    state: np.ndarray
    stamps: np.ndarray


class Deviations(NamedTuple):
    """Standard deviations of the noise, in m, m/s, rad, rad/s, and rad of each joint."""

    position: float
    velocity: float
    attitude: float
    rate: float
    joint: float

    @classmethod
    def make(cls, config: Sensors) -> Self:
        """Returns the deviations that a scenario's sensors have."""
        return cls(
            config.position_noise_m,
            config.velocity_noise_m_s,
            config.attitude_noise_rad,
            config.rate_noise_rad_s,
            config.joint_noise_rad,
        )


def group_columns(group: str, joints: int) -> np.ndarray:
    """Returns the indices of a group's entries in a sample (13 + 2 n,).

    Args:
        group: One of `GROUPS`, or `all`.
        joints: n.
    """
    at = split_state(np.arange(float(VehicleState.size(joints))))
    groups = {
        "position": (at.p_B, at.v_B),
        "attitude": (at.quaternion, at.omega_W),
        "joints": (at.q, at.qdot),
    }
    groups["all"] = sum(groups.values(), ())
    return np.concatenate(groups[group]).astype(int)


def noise_size(joints: int) -> int:
    """Returns the number of independent draws of one sample: 12 of the base, one per joint."""
    return 12 + joints


@compiled
def sampled(arm: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Returns the state (13 + 2 n,) with the arm of `arm` and the base of `base`."""
    state = base.copy()
    _, _, q, _, _, qdot = split_state(state)
    _, _, q[:], _, _, qdot[:] = split_state(arm)
    return state


@compiled
def moved_back(state: np.ndarray, time_s: float) -> np.ndarray:
    """Returns a state (13 + 2 n,) with the base of `time_s` s before, at constant velocity."""
    before = state.copy()
    quaternion, p_B, _, omega_W, v_B, _ = split_state(before)
    p_B -= time_s * v_B
    turn = apply(rotation_matrix(quaternion).T, omega_W)
    quaternion[:] = turned(quaternion, -time_s * turn)
    return before


@compiled
def noisy(sigma: Deviations, x: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Returns the state vector x with measurement noise.

    Args:
        sigma: Standard deviations.
        x: (13 + 2 n,) the true state, as `VehicleState` has it.
        noise: (12 + n,) standard normal draws: position, velocity, attitude (roll,
            pitch and yaw from the true one), rates (3 each), joint angles.

    Returns:
        (13 + 2 n,), the quaternion's w at least 0.
    """
    measured = x.copy()
    quaternion, p_B, q, omega_W, v_B, _ = split_state(measured)
    p_B += sigma.position * noise[:3]
    v_B += sigma.velocity * noise[3:6]
    omega_W += sigma.rate * noise[9:12]
    q += sigma.joint * noise[12:]
    off = product(quaternion, quaternion_of(sigma.attitude * noise[6:9]))
    quaternion[:] = off / np.copysign(length(off), off[0])
    return measured


@compiled
def group_of(g: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns views of the values and velocities of group `g` of a state x (13 + 2 n,)."""
    quaternion, p_B, q, omega_W, v_B, qdot = split_state(x)
    if g == POSITION:
        return p_B, v_B
    if g == ATTITUDE:
        return quaternion, omega_W
    return q, qdot


@compiled
def replace_group(g: int, x: np.ndarray, source: np.ndarray) -> None:
    """Replaces group `g` of the state x by that of the state `source`, (13 + 2 n,) each."""
    value, rate = group_of(g, x)
    value[:], rate[:] = group_of(g, source)

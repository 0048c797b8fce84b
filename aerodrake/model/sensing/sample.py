"""Samples of the vehicle's state, and the noise on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.rotation import length, product, quaternion_of
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Sensors
from aerodrake.support.compiled import compiled

GROUPS = ("position", "attitude", "joints")
"""Of a sample, since three sensors make it: p_B and v_B, quaternion and omega_W, q and q'."""

POSITION, ATTITUDE, JOINTS = range(3)
"""Where each is among them."""


class Deviations(NamedTuple):
    """Standard deviations of the noise.

    Attributes:
        position: m.
        velocity: m/s.
        attitude: rad.
        rate: rad/s.
        joint: rad, of each.
    """

    position: float
    velocity: float
    attitude: float
    rate: float
    joint: float

    @classmethod
    def make(cls, config: Sensors) -> Deviations:
        """Of the scenario."""
        return cls(
            config.position_noise_m,
            config.velocity_noise_m_s,
            config.attitude_noise_rad,
            config.rate_noise_rad_s,
            config.joint_noise_rad,
        )


def group_columns(group: str, joints: int) -> np.ndarray:
    """Where the numbers of a group of samples, or those of `all`, are in a sample (13 + 2 n,).

    Args:
        group: As a `SampleFault` names it.
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
    """How many independent draws one sample takes: base 12, and one per joint."""
    return 12 + joints


@compiled
def sampled(arm: np.ndarray, base: np.ndarray) -> np.ndarray:
    """(13 + 2 n,) the arm of the state `arm` and the base of the state `base`, (13 + 2 n,) each."""
    found = base.copy()
    _, _, q, _, _, qdot = split_state(found)
    _, _, q[:], _, _, qdot[:] = split_state(arm)
    return found


@compiled
def disturbed(sigma: Deviations, x: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """The state vector x with measurement noise on it.

    Args:
        sigma: Standard deviations.
        x: (13 + 2 n,) the true state, as `VehicleState` has it.
        noise: (12 + n,) standard normal draws: position, velocity, attitude (roll,
            pitch and yaw from the true one), rates (3 each), joint angles.

    Returns:
        (13 + 2 n,), the quaternion's w at least 0.
    """
    found = x.copy()
    quaternion, p_B, q, omega_W, v_B, _ = split_state(found)
    p_B += sigma.position * noise[:3]
    v_B += sigma.velocity * noise[3:6]
    omega_W += sigma.rate * noise[9:12]
    q += sigma.joint * noise[12:]
    turned = product(quaternion, quaternion_of(sigma.attitude * noise[6:9]))
    quaternion[:] = turned / np.copysign(length(turned), turned[0])
    return found


@compiled
def group_of(g: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and velocities of a group, by its number, of a sample x (13 + 2 n,); views."""
    quaternion, p_B, q, omega_W, v_B, qdot = split_state(x)
    if g == POSITION:
        return p_B, v_B
    if g == ATTITUDE:
        return quaternion, omega_W
    return q, qdot

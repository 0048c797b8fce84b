"""Backlash and flexibility between motors and links."""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.compiled import compiled


class JointTransmission(NamedTuple):
    """A gap and a spring between the motor and the link of n joints.

    The motor has no inertia of its own, since the URDF's rotor inertia moves with the link. Its
    angle is that of the link plus the twist s. The transmission's torque is that of a spring with
    a dead zone (Nordin and Gutman 2002, "Controlling mechanical systems with backlash - a survey"),

        T = (s - s_g) / flexibility, where s_g is s limited to +- backlash / 2,

    and the motor turns relative to the link by damping s' = torque - T. Damping is the slope of
    the motor's torque-speed line between its limits: torque over velocity. At rest,
    s = flexibility torque +- backlash / 2.

    Attributes:
        gap: (n,) rad, half of the backlash.
        flexibility: (n,) rad/(N m).
        damping: (n,) N m s/rad.
        dt: s.
    """

    gap: np.ndarray
    flexibility: np.ndarray
    damping: np.ndarray
    dt: float

    @classmethod
    def make(cls, config: Actuation, vehicle: VehicleModel, dt: float) -> Self:
        """Returns the transmission of a vehicle's joints.

        Args:
            config: Backlash and flexibility.
            vehicle: Limits of the joints.
            dt: s, period of the plant.

        Raises:
            ScenarioError: if a list of values has the wrong length.
        """
        flexibility = vehicle.per_joint(config.flexibility_rad_n_m, "actuation.flexibility_rad_n_m")
        return cls(
            gap=vehicle.per_joint(config.backlash_rad, "actuation.backlash_rad") / 2,
            flexibility=flexibility.copy(),
            damping=vehicle.effort / vehicle.velocity,
            dt=dt,
        )

    def at_rest(self, torque: np.ndarray) -> np.ndarray:
        """Returns the twists (n,) rad at rest under `torque` (n,) N m; without torque mid-gap."""
        side = np.sign(np.round(torque, 9))  # Joints without load have torques of rounding alone.
        return self.flexibility * torque + side * self.gap


@compiled
def twist(transmission: JointTransmission, last: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Returns the twists (n,) rad after a step; exact for constant torques.

    Args:
        transmission: The transmission.
        last: (n,) rad, twists before the step.
        torque: (n,) N m, of the motors during the step.
    """
    after = np.empty(len(last))
    for i in range(len(last)):
        gap, flexibility = transmission.gap[i], transmission.flexibility[i]
        damping = transmission.damping[i]
        after[i] = _twist(gap, flexibility, damping, last[i], torque[i], transmission.dt)
    return after


@compiled
def transmitted(
    transmission: JointTransmission, last: np.ndarray, torque: np.ndarray
) -> np.ndarray:
    """Returns the mean torques (n,) N m on the links during a step.

    Args:
        transmission: The transmission.
        last: (n,) rad, twists before the step.
        torque: (n,) N m, of the motors during the step.
    """
    turned = twist(transmission, last, torque) - last
    return torque - transmission.damping * turned / transmission.dt


@compiled
def _twist(
    gap: float, flexibility: float, damping: float, s: float, torque: float, time: float
) -> float:
    """Returns the twist of one joint after a time in s, from a twist s in rad."""
    lag, side = flexibility * damping, math.copysign(1.0, s)
    beyond = side * s - gap
    if beyond > 0.0 and lag > 0.0:  # On the spring of this side.
        end = flexibility * side * torque
        leaves_after = lag * math.log((beyond - end) / -end) if end < 0.0 else math.inf
        if leaves_after >= time:
            return side * (gap + end + (beyond - end) * math.exp(-time / lag))
        s, time = side * gap, time - leaves_after
    if torque == 0.0:
        return s
    side = math.copysign(1.0, torque)
    arrives_after = (gap - side * s) * damping / abs(torque)
    if arrives_after >= time:  # In the gap.
        return s + torque * time / damping
    if lag == 0.0:
        return side * gap
    pressed = 1.0 - math.exp((arrives_after - time) / lag)
    return side * (gap + flexibility * abs(torque) * pressed)

"""Backlash and flexibility between motors and links."""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.compiled import compiled


class JointTransmission(NamedTuple):
    """A gap and a spring between the motor and the link of n joints.

    The motor's angle is that of the link plus the twist s. The spring has a dead zone (Nordin and
    Gutman 2002, "Controlling mechanical systems with backlash - a survey"),

        T = (s - s_g) / flexibility, where s_g is s limited to +- backlash / 2,

    and the motor turns relative to the link by damping s' = load - T. The load is the motor's
    torque less that which gives the motor itself the link's acceleration. Damping is the slope
    of the motor's torque-speed line between its limits: torque over velocity. At rest,
    s = flexibility * torque +- backlash / 2.

    The link gets the motor's torque while the motor is not in the gap, since the plant's links
    contain the inertia of their motors.

    Attributes:
        gap: (n,) rad, half of the backlash.
        flexibility: (n,) rad/(N m).
        damping: (n,) N m s/rad.
        motor_inertia: (n,) kg m^2, after the gear.
        effort: (n,) N m, largest torque.
        dt: s.
    """

    gap: np.ndarray
    flexibility: np.ndarray
    damping: np.ndarray
    motor_inertia: np.ndarray
    effort: np.ndarray
    dt: float

    @classmethod
    def make(cls, config: Actuation, vehicle: VehicleModel, dt: float) -> Self:
        """Returns the transmission of a vehicle's joints.

        Args:
            config: Backlash and flexibility.
            vehicle: Motors and limits of the joints.
            dt: s, period of the plant.

        Raises:
            ScenarioError: if a list of values has the wrong length.
        """
        flexibility = vehicle.per_joint(config.flexibility_rad_n_m, "actuation.flexibility_rad_n_m")
        plant = vehicle.plant
        motors = map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
        inertia = {motor.joint().name(): motor.default_reflected_inertia() for motor in motors}
        return cls(
            gap=vehicle.per_joint(config.backlash_rad, "actuation.backlash_rad") / 2,
            flexibility=flexibility.copy(),
            damping=vehicle.effort / vehicle.velocity,
            motor_inertia=np.array([inertia[name] for name in vehicle.joint_names]),
            effort=vehicle.effort,
            dt=dt,
        )

    def at_rest(self, torque: np.ndarray) -> np.ndarray:
        """Returns the twists (n,) rad at rest under `torque` (n,) N m; without torque mid-gap."""
        side = np.sign(np.round(torque, 9))  # Joints without load have torques of rounding alone.
        return self.flexibility * torque + side * self.gap


class Turn(NamedTuple):
    """Motion of the motors relative to their links in a step.

    Attributes:
        twist: (n,) rad, after the step.
        contact: (n,) part of the step for which each motor is not in the gap, 0 to 1.
    """

    twist: np.ndarray
    contact: np.ndarray


@compiled
def load(transmission: JointTransmission, torque: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Returns the torques (n,) N m that load the transmissions.

    Args:
        transmission: The transmission.
        torque: (n,) N m, of the motors.
        change: (n,) rad/s, change of the links' velocities in the last step.
    """
    loads = torque - transmission.motor_inertia * change / transmission.dt
    return np.minimum(np.maximum(loads, -transmission.effort), transmission.effort)


@compiled
def turn(transmission: JointTransmission, last: np.ndarray, loads: np.ndarray) -> Turn:
    """Returns the motion in a step; exact for constant loads.

    Args:
        transmission: The transmission.
        last: (n,) rad, twists before the step.
        loads: (n,) N m, loads during the step.
    """
    after, contact = np.empty(len(last)), np.empty(len(last))
    for i in range(len(last)):
        gap, flexibility = transmission.gap[i], transmission.flexibility[i]
        damping, dt = transmission.damping[i], transmission.dt
        after[i], crossing_s = _turn(gap, flexibility, damping, last[i], loads[i], dt)
        contact[i] = 1.0 - crossing_s / dt
    return Turn(after, contact)


@compiled
def _turn(
    gap: float, flexibility: float, damping: float, s: float, torque: float, time: float
) -> tuple[float, float]:
    """Returns twist and time in the gap of one joint after a time in s, from a twist s in rad."""
    lag, side = flexibility * damping, math.copysign(1.0, s)
    beyond = side * s - gap
    if beyond > 0.0 and lag > 0.0:  # On the spring of this side.
        end = flexibility * side * torque
        leaves_after = lag * math.log((beyond - end) / -end) if end < 0.0 else math.inf
        if leaves_after >= time:
            return side * (gap + end + (beyond - end) * math.exp(-time / lag)), 0.0
        s, time = side * gap, time - leaves_after
    if torque == 0.0:
        return s, time if gap > 0.0 else 0.0
    side = math.copysign(1.0, torque)
    arrives_after = (gap - side * s) * damping / abs(torque)
    if arrives_after >= time:  # In the gap.
        return s + torque * time / damping, time
    if lag == 0.0:
        return side * gap, arrives_after
    pressed = 1.0 - math.exp((arrives_after - time) / lag)
    return side * (gap + flexibility * abs(torque) * pressed), arrives_after

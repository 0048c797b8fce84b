"""Vehicle section of a scenario: the robot, its rotors and its initial configuration."""

from __future__ import annotations

from dataclasses import dataclass

from aerodrake.scenario.schema import file, quantity


@dataclass(frozen=True)
class Rotor:
    """One rotor: its thrust range, first-order lag and drag torque."""

    min_thrust_n: float = quantity(0.0, "N", 0.0, 100.0)
    max_thrust_n: float = quantity(20.0, "N", 0.1, 1000.0)
    # Drag torque divided by thrust.
    torque_ratio_m: float = quantity(0.020, "m", 1e-3, 1.0)
    # Time constants of rising and of falling thrust.
    lag_up_s: float = quantity(0.0125, "s", 1e-3, 1.0)
    lag_down_s: float = quantity(0.025, "s", 1e-3, 1.0)


@dataclass(frozen=True)
class Vehicle:
    """Robot and initial configuration."""

    # A URDF.
    robot: str = file("package://aerodrake/robots/quadrotor_arm6.urdf")
    base_position_m: tuple[float, ...] = quantity((0.0, 0.0, 1.5), "m", -100, 100, length=3)
    # Initial angle of each joint. The end-effector's position in the base frame at these angles
    # is p_O, the centre of the learning space.
    working_rad: tuple[float, ...] = quantity(
        (0.0, -0.13761843, 1.79340966, 0.0, -1.65579123, 0.0), "rad", -6.2832, 6.2832
    )
    rotor: Rotor = Rotor()

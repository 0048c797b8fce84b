"""What the vehicle meets: how it is sensed, the air, what it carries, how it is off its model."""

from __future__ import annotations

from dataclasses import dataclass

from aerodrake.scenario.schema import quantity


@dataclass(frozen=True)
class Sensors:
    """Standard deviations of white noise, one draw per sample and axis; and what comes late."""

    position_noise_m: float = quantity(0.0, "m", 0.0, 1.0)
    velocity_noise_m_s: float = quantity(0.0, "m/s", 0.0, 1.0)
    attitude_noise_rad: float = quantity(0.0, "rad", 0.0, 0.2)
    rate_noise_rad_s: float = quantity(0.0, "rad/s", 0.0, 1.0)
    joint_noise_rad: float = quantity(0.0, "rad", 0.0, 0.2)
    # Of the base's attitude, position and velocities; joints are never late.
    base_delay_s: float = quantity(0.0, "s", 0.0, 0.5)


@dataclass(frozen=True)
class Wind:
    """Moving air, and the force it exerts at the base's origin, in the world frame.

    Air at rest, with neither wind nor gusts, exerts none, not even on a base that
    flies through it.
    """

    velocity_m_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s", -20.0, 20.0, length=3)
    # Gusts: an Ornstein-Uhlenbeck process on each axis, by standard deviation and correlation time.
    gust_m_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s", 0.0, 10.0, length=3)
    gust_correlation_s: float = quantity(1.0, "s", 0.05, 100.0)
    # quadratic |v_r| v_r + linear v_r, for the air's velocity v_r as the base feels it.
    quadratic_drag_n_s2_m2: float = quantity(0.25, "N s^2/m^2", 0.0, 10.0)
    linear_drag_n_s_m: float = quantity(0.15, "N s/m", 0.0, 10.0)


@dataclass(frozen=True)
class Payload:
    """A small steel ball at the end-effector, which no controller knows of."""

    mass_kg: float = quantity(0.0, "kg", 0.0, 2.0)


@dataclass(frozen=True)
class Mismatch:
    """How the plant is off the model that all controllers have: factors, 1 for none."""

    # Of every link's mass, and of its inertia about its own centre of mass.
    mass_scale: float = quantity(1.0, "1", 0.5, 2.0)
    inertia_scale: float = quantity(1.0, "1", 0.5, 2.0)
    # Of both time constants of the rotors.
    rotor_lag_scale: float = quantity(1.0, "1", 0.2, 5.0)
    # Of how far each rotor's commanded thrust is from its trim: the loop gain.
    thrust_scale: float = quantity(1.0, "1", 0.1, 5.0)

"""Environment sections of a scenario: physics, wind, air, payload and model mismatch."""

from dataclasses import dataclass

from aerodrake.scenario.schema import Section, choice, quantity


@dataclass(frozen=True)
class Physics(Section):
    """Physics engine of the plant, which has the same vehicle in each."""

    # mujoco expects the extra [mujoco].
    engine: str = choice("drake", "mujoco")
    # Integrator of MuJoCo, and number of its time steps in a step of the plant.
    integrator: str = choice("implicitfast", "euler", "rk4")
    substeps: int = quantity(1, "1", 1, 100)


@dataclass(frozen=True)
class Wind(Section):
    """Wind, and the drag force that it exerts at the base's origin, in the world frame.

    Without wind and gusts there is no drag, even if the base moves.
    """

    # Mean velocity of the air.
    velocity_m_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s", -20.0, 20.0, length=3)
    # Gusts, an Ornstein-Uhlenbeck process on each axis: standard deviation and correlation time.
    gust_m_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s", 0.0, 10.0, length=3)
    gust_correlation_s: float = quantity(1.0, "s", 0.05, 100.0)
    # Force quadratic |v_r| v_r + linear v_r, for the air's velocity v_r relative to the base.
    quadratic_drag_n_s2_m2: float = quantity(0.25, "N s^2/m^2", 0.0, 10.0)
    linear_drag_n_s_m: float = quantity(0.15, "N s/m", 0.0, 10.0)
    # Exponent of the mean velocity's power law over the height; 0 is the same at all heights. The
    # mean velocity is that at the reference height.
    shear_exponent: float = quantity(0.0, "1", 0.0, 1.0)
    reference_height_m: float = quantity(1.5, "m", 0.1, 100.0)
    # Wave in space: wave_m_s sin(wave_rad_m . p) at the position p, at all times.
    wave_m_s: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m/s", -10.0, 10.0, length=3)
    wave_rad_m: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "rad/m", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class Air(Section):
    """Effects of the air on the rotors, which no controller's model contains."""

    # Drag of all rotors together per velocity relative to the air, in the rotors' plane.
    rotor_drag_n_s_m: float = quantity(0.0, "N s/m", 0.0, 10.0)
    # Fraction of a rotor's thrust that is lost per velocity along its axis against the air.
    inflow_s_m: float = quantity(0.0, "s/m", 0.0, 1.0)
    # Radius of a rotor; near the ground and the ceiling its thrust increases. 0 for neither.
    rotor_radius_m: float = quantity(0.0, "m", 0.0, 2.0)
    # Height of the ceiling; 0 for none.
    ceiling_m: float = quantity(0.0, "m", 0.0, 1000.0)


@dataclass(frozen=True)
class Payload(Section):
    """A small steel ball at the end-effector, which is not part of any controller's model."""

    mass_kg: float = quantity(0.0, "kg", 0.0, 2.0)


@dataclass(frozen=True)
class Mismatch(Section):
    """Model mismatch: factors on the plant's parameters, which the controllers do not have."""

    # Factors on each link's mass and on its inertia about its own centre of mass.
    mass_scale: float = quantity(1.0, "1", 0.5, 2.0)
    inertia_scale: float = quantity(1.0, "1", 0.5, 2.0)
    # Factor on both time constants of the rotors.
    rotor_lag_scale: float = quantity(1.0, "1", 0.2, 5.0)
    # Factor on the loop gain: on the deviation of each rotor's commanded thrust from trim.
    thrust_scale: float = quantity(1.0, "1", 0.1, 5.0)
    # The same of the joints: on the deviation of each joint's commanded torque from trim.
    torque_scale: float = quantity(1.0, "1", 0.1, 10.0)
    # Offset of the centre of mass of the base's link, in its frame.
    centre_of_mass_m: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "m", -0.2, 0.2, length=3)

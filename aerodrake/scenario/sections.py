"""Sections of a scenario: the data that defines one flight.

Each class is one mapping of the YAML file, each field one key. A field is declared with its
default, its unit and its range; a comment above it gives its meaning. Symbols are the paper's.
"""

from dataclasses import dataclass

from aerodrake.scenario.schema import Section, choice, file, quantity
from aerodrake.support.limits import THRUST_N


@dataclass(frozen=True)
class Rates(Section):
    """Periods of the discrete updates. Each is a multiple of `plant_step_s`."""

    plant_step_s: float = quantity(0.001, "s", 1e-4, 5e-3)
    sensor_period_s: float = quantity(0.010, "s", 1e-3, 0.1)
    flight_period_s: float = quantity(0.010, "s", 1e-3, 0.1)
    arm_period_s: float = quantity(0.005, "s", 1e-3, 0.1)
    # Period of the MPC, and of the allocator and residual estimator, whose outputs it evaluates.
    mpc_period_s: float = quantity(0.020, "s", 2e-3, 0.2)


@dataclass(frozen=True)
class Rotor(Section):
    """One rotor: range of thrust, drag torque over thrust, time constants of rise and fall."""

    min_thrust_n: float = quantity(0.0, "N", 0.0, 100.0)
    max_thrust_n: float = quantity(20.0, "N", *THRUST_N)
    torque_ratio_m: float = quantity(0.020, "m", 1e-3, 1.0)
    lag_up_s: float = quantity(0.0125, "s", 1e-3, 1.0)
    lag_down_s: float = quantity(0.025, "s", 1e-3, 1.0)


@dataclass(frozen=True)
class Vehicle(Section):
    """Robot, its rotors and initial configuration."""

    # A URDF.
    robot: str = file("package://aerodrake/robots/quadrotor_arm6.urdf")
    base_position_m: tuple[float, ...] = quantity((0.0, 0.0, 1.5), "m", -100, 100, length=3)
    # Initial angle of each joint. The end-effector's position in the base frame at these angles
    # is p_O, the centre of the learning space.
    working_rad: tuple[float, ...] = quantity(
        (0.0, -0.13761843, 1.79340966, 0.0, -1.65579123, 0.0), "rad", -6.2832, 6.2832
    )
    rotor: Rotor = Rotor()


@dataclass(frozen=True)
class Filter(Section):
    """Kalman filters that estimate the state, and the base's disturbance, from the samples.

    With `none`, or if samples are exact and the assumed delay is zero, the state is the sample.
    """

    kind: str = choice("kalman", "none")
    # Assumed delay of the base's samples; the filter predicts over it.
    delay_s: float = quantity(0.0, "s", 0.0, 0.5)
    # Assumed standard deviations of the samples' noise. The large one of the velocity makes the
    # filter tolerate a real delay above the assumed one.
    position_noise_m: float = quantity(0.002, "m", 1e-6, 1.0)
    velocity_noise_m_s: float = quantity(0.1, "m/s", 1e-6, 10.0)
    attitude_noise_rad: float = quantity(0.0035, "rad", 1e-6, 0.2)
    rate_noise_rad_s: float = quantity(0.01, "rad/s", 1e-6, 10.0)
    joint_noise_rad: float = quantity(0.0009, "rad", 1e-6, 0.2)
    # The same of the accelerometer's mean over a sensor period; 0 leaves it out.
    accelerometer_noise_m_s2: float = quantity(0.0, "m/s^2", 0.0, 100.0)
    # Random-walk intensities of the disturbances of the base's linear and angular acceleration.
    disturbance_m_s3: float = quantity(0.2, "m/s^2/sqrt(s)", 1e-3, 1e3)
    disturbance_rad_s3: float = quantity(3.0, "rad/s^2/sqrt(s)", 1e-3, 1e4)
    # Jump of the measured position from which the filter starts again, as after a reset of the
    # estimator that measures it: its largest size, and the time for which it has to last.
    reset_m: float = quantity(1.0, "m", 0.0, 100.0)
    reset_after_s: float = quantity(0.8, "s", 0.0, 60.0)


@dataclass(frozen=True)
class Supervisor(Section):
    """Thresholds and durations at which the supervisor leaves NOMINAL.

    The conditions are defined in `aerodrake.model.supervision.conditions`.
    """

    # Number of ticks for which the MPC's last plan is followed if it computes no new one.
    plan_ticks: int = quantity(5, "ticks", 1, 1000)
    # Time without a new plan after which the vehicle lands.
    plan_lost_s: float = quantity(5.0, "s", 0.02, 3600.0)
    # Time since the last accepted sample of a group after which the vehicle holds (`outage`), and
    # after which it lands, or for attitude stops its rotors (`lost`). Until then the state is
    # predicted.
    position_outage_s: float = quantity(0.3, "s", 0.02, 60.0)
    position_lost_s: float = quantity(1.5, "s", 0.02, 60.0)
    attitude_outage_s: float = quantity(0.2, "s", 0.02, 60.0)
    attitude_lost_s: float = quantity(0.4, "s", 0.02, 60.0)
    joints_outage_s: float = quantity(0.15, "s", 0.02, 60.0)
    joints_lost_s: float = quantity(1.0, "s", 0.02, 60.0)
    # Amplitude of the rate with which a joint oscillates about its setpoint, at 2 Hz or more, from
    # which the vehicle holds; and the time after which it lands if that does not end it.
    joint_oscillation_rad_s: float = quantity(0.5, "rad/s", 0.05, 100.0)
    joints_unstable_s: float = quantity(1.0, "s", 0.02, 60.0)
    # Time for which the cause of a mode must be absent before the mode is left.
    clear_s: float = quantity(0.5, "s", 0.0, 60.0)
    # Tilt of the base at which the rotors stop.
    max_tilt_rad: float = quantity(1.0472, "rad", 0.1, 1.0472)
    # Fraction of its commanded thrust below which a rotor counts as lost.
    rotor_lost: float = quantity(0.45, "1", 0.0, 1.0)
    # Envelope of the reference: least height, largest distance from the initial position, and
    # largest speed along each axis. References outside it are not followed.
    lowest_m: float = quantity(0.1, "m", -1000.0, 1000.0)
    farthest_m: float = quantity(50.0, "m", 0.1, 10_000.0)
    fastest_m_s: float = quantity(1.5, "m/s", 0.01, 100.0)
    # Speed of landing.
    descend_m_s: float = quantity(0.3, "m/s", 0.05, 2.0)


@dataclass(frozen=True)
class Flight(Section):
    """Flight controller with extended state observers; gains are per unit mass and inertia."""

    # Base setpoint: `trajectory` is (p_d, v_d, a_d), `position` is p_d alone as in the paper.
    interface: str = choice("trajectory", "position")
    position_gain: tuple[float, ...] = quantity((9.0, 9.0, 9.0), "1/s^2", 0.0, 400.0, length=3)
    velocity_gain: tuple[float, ...] = quantity((5.0, 5.0, 5.0), "1/s", 0.0, 100.0, length=3)
    integral_gain: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "1/s^3", 0.0, 400.0, length=3)
    # About the base's roll, pitch and yaw axes.
    attitude_gain: tuple[float, ...] = quantity(
        (144.0, 144.0, 36.0), "1/s^2", 0.0, 1000.0, length=3
    )
    rate_gain: tuple[float, ...] = quantity((24.0, 24.0, 12.0), "1/s", 0.0, 200.0, length=3)
    # Bandwidths of the observers.
    position_eso_rad_s: float = quantity(3.0, "rad/s", 0.1, 100.0)
    attitude_eso_rad_s: float = quantity(15.0, "rad/s", 0.1, 100.0)
    # Time constant of the low-pass filter of omega_d, the desired attitude's angular velocity.
    rate_filter_s: float = quantity(0.03, "s", 0.0, 1.0)
    # Inverse dynamics of the arm's commanded motion: its torque, with filtered accelerations, and
    # its force in the base's modelled acceleration alone; torque and force, with unfiltered ones
    # (whole_body); or none: the observers estimate them. The force tilts the base and accelerations
    # turn it, which closes a loop through the MPC: whole_body is unstable for long or heavy arms,
    # and with noise and unknown delay. none is unstable for arms nearly as heavy as the base.
    feedforward: str = choice("torque", "whole_body", "none")
    # Largest tilt of the desired attitude.
    max_tilt_rad: float = quantity(0.6, "rad", 0.05, 1.2)


@dataclass(frozen=True)
class Arm(Section):
    """Joint PID controller; its gains are computed from the joints' inertia."""

    # Inertia that turns accelerations of the joints into torques: the arm's inertia matrix with a
    # free base, or its diagonal as in the paper, unstable for arms with light distal links.
    inertia: str = choice("coupled", "diagonal")
    # Natural frequency and damping ratio of each joint's closed loop. With lower frequencies and
    # late samples, the attitude loop is unstable for arms heavier than the base.
    bandwidth_rad_s: float = quantity(60.0, "rad/s", 1.0, 200.0)
    damping: float = quantity(1.0, "1", 0.1, 5.0)
    # Rate at which the integral action removes a constant torque error.
    integral_rad_s: float = quantity(5.0, "rad/s", 0.0, 50.0)


@dataclass(frozen=True)
class Model(Section):
    """Equivalent model of the base with its flight controller."""

    # flight: the closed loop with its gains and rotor lag. velocity_aware: first order with v_d.
    # paper: first order, semi-implicit Euler. exact: the same with zero-order hold.
    # integral: the base is always at its setpoint.
    kind: str = choice("flight", "velocity_aware", "paper", "exact", "integral")
    # K_B of the first-order models. It depends on the flight interface and gains; the default
    # is identified for the default ones by `aerodrake identify hover`.
    k_b: tuple[float, ...] = quantity((1.71, 1.71, 1.71), "1/s", 0.01, 50.0, length=3)


@dataclass(frozen=True)
class Weights(Section):
    """K_e and the diagonals of W_1 ... W_4; for the joints one value, or one per joint."""

    # Gain K_e of the desired end-effector velocity.
    k_e: tuple[float, ...] = quantity((16.0, 16.0, 16.0), "1/s", 0.0, 50.0, length=3)
    w_1: tuple[float, ...] = quantity((1e4, 1e4, 1e4), "1", 0.0, 1e8, length=3)
    w_2_base: tuple[float, ...] = quantity((1e-4, 1e-4, 1e-4), "1", 0.0, 1e6, length=3)
    w_2_joints: tuple[float, ...] = quantity((1.0,), "1", 0.0, 1e6)
    w_3_base: tuple[float, ...] = quantity((30.0, 30.0, 30.0), "1", 1e-3, 1e6, length=3)
    w_3_joints: tuple[float, ...] = quantity((3.0,), "1", 1e-3, 1e6)
    w_4: tuple[float, ...] = quantity((3000.0, 3000.0, 3000.0), "1", 0.0, 1e6, length=3)


@dataclass(frozen=True)
class Mpc(Weights):
    """Horizon of N stages, weights and bounds of the MPC. The URDF has the joints' limits."""

    horizon: int = quantity(15, "stages", 2, 200)
    # Length of the horizon. The first stage lasts one tick; the others grow geometrically.
    span_ticks: int = quantity(100, "ticks", 1, 1000)
    # Bound of the norm of the correction K_e e_E, for targets that are far away.
    approach_speed_m_s: float = quantity(0.8, "m/s", 0.01, 100.0)
    # e_E over the horizon: predicted with the linearised p_E, or constant as in the paper.
    error: str = choice("predicted", "frozen")
    # Diagonal of W_5, on changes of the base's acceleration from one stage to the next.
    w_5: tuple[float, ...] = quantity((3000.0, 3000.0, 3000.0), "1", 0.0, 1e6, length=3)
    # Orientation task: weight W_6, gain K_o, and bound of the correction K_o e_o.
    w_6: float = quantity(100.0, "1", 0.0, 1e8)
    k_o: float = quantity(8.0, "1/s", 0.0, 50.0)
    approach_speed_rad_s: float = quantity(0.8, "rad/s", 0.01, 100.0)
    # Roll and pitch rates in J_u xi_u': predicted from the base's acceleration by differential
    # flatness, zero, or measured and constant over the horizon.
    tilt: str = choice("flatness", "none", "held")
    # Bounds of the base's commanded velocity and acceleration.
    base_velocity_m_s: tuple[float, ...] = quantity((1.5, 1.5, 1.5), "m/s", 0.01, 20.0, length=3)
    base_acceleration_m_s2: tuple[float, ...] = quantity(
        (2.5, 2.5, 2.5), "m/s^2", 0.1, 20.0, length=3
    )
    # Solver of the programs: OSQP, the package's own active-set method, or another of Drake's.
    solver: str = choice("osqp", "active_set", "clarabel", "gurobi", "mosek", "scs")
    # Accepts the unconstrained minimiser, without calling the solver, if it satisfies all bounds.
    shortcut: bool = True
    # Iteration limit of `osqp` and `active_set`; the others have their own.
    max_iterations: int = quantity(400, "iterations", 25, 100_000)


@dataclass(frozen=True)
class Clik(Section):
    """Closed-loop inverse kinematics; K_e, approach speed and bounds are those of `mpc`."""

    # lambda of the damped least squares, for weights scaled to a minimum of 1.
    damping: float = quantity(0.02, "1", 1e-4, 10.0)
    # Rate of the null-space motion that returns the arm to the centre of its learning space.
    centring_1_s: float = quantity(4.0, "1/s", 0.0, 50.0)
    # Bandwidth of the first-order loop from desired to commanded velocity; 1 / period is deadbeat.
    bandwidth_1_s: float = quantity(15.0, "1/s", 0.1, 500.0)


@dataclass(frozen=True)
class Allocation(Section):
    """Weight allocation: gamma, its gains and its boundaries."""

    # gamma: weights depend on the distances. fixed: constant weights, those of `fixed_gamma` at
    # d_o = d_h / 2.
    kind: str = choice("gamma", "fixed")
    fixed_gamma: float = quantity(1.0, "1", -1.0, 1.0)
    k_q: float = quantity(1000.0, "1", 0.0, 1e6)
    k_m: float = quantity(10.0, "1", 0.0, 1e6)
    k_d: float = quantity(100.0, "1/m", 0.0, 1e6)
    k_mp: float = quantity(1.0, "m", 1e-3, 100.0)
    k_mn: float = quantity(1.0, "1", 1e-3, 100.0)
    d_edge_m: float = quantity(0.38, "m", 1e-3, 10.0)
    d_f_m: float = quantity(1.0, "m", 1e-3, 100.0)
    d_h_m: float = quantity(0.075, "m", 1e-3, 10.0)
    # Relative hysteresis h of d_f and d_h: a boundary d is crossed outward at (1 + h) d and inward
    # at d; 0 is the paper's.
    hysteresis: float = quantity(0.1, "1", 0.0, 1.0)
    # Lower bound of d_o in w_d, so that J_4 never vanishes.
    d_o_floor_m: float = quantity(0.01, "m", 1e-4, 1.0)
    # Size of the learning space, a box in the base frame whose centre is p_O.
    learning_space_m: tuple[float, ...] = quantity((0.15, 0.15, 0.10), "m", 0.01, 10.0, length=3)

"""Scenarios: everything that is told apart from one flight to another.

A scenario is a YAML file. Each section below is one mapping in it, each field
one key, with its unit and range where it is declared; keys that are left out
have the defaults that stand here. Symbols are the paper's.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from aerodrake.scenario.environment import Mismatch, Payload, Sensors, Wind
from aerodrake.scenario.faults import AnyFault
from aerodrake.scenario.references import Hover, Orientation, OrientationOff, Reference
from aerodrake.scenario.schema import choice, file, provenance, quantity, several


@dataclass(frozen=True)
class Rates:
    """Periods of the discrete events. Each is a multiple of `plant_step_s`."""

    plant_step_s: float = quantity(0.001, "s", 1e-4, 5e-3)
    sensor_period_s: float = quantity(0.010, "s", 1e-3, 0.1)
    flight_period_s: float = quantity(0.010, "s", 1e-3, 0.1)
    arm_period_s: float = quantity(0.005, "s", 1e-3, 0.1)
    # The MPC, and the allocator and residual estimator whose outputs it pulls.
    mpc_period_s: float = quantity(0.020, "s", 2e-3, 0.2)


@dataclass(frozen=True)
class Rotor:
    """One rotor: thrust in [min, max], first-order lag, drag torque over thrust."""

    min_thrust_n: float = quantity(0.0, "N", 0.0, 100.0)
    max_thrust_n: float = quantity(20.0, "N", 0.1, 1000.0)
    torque_ratio_m: float = quantity(0.020, "m", 1e-3, 1.0)
    lag_up_s: float = quantity(0.0125, "s", 1e-3, 1.0)
    lag_down_s: float = quantity(0.025, "s", 1e-3, 1.0)


@dataclass(frozen=True)
class Vehicle:
    """The robot and the configuration in which it starts."""

    robot: str = file("package://aerodrake/robots/quadrotor_arm6.urdf")
    base_position_m: tuple[float, ...] = quantity((0.0, 0.0, 1.5), "m", -100, 100, length=3)
    # One angle per joint; where it puts the end-effector in the base frame is
    # p_O, the centre of the learning space.
    working_rad: tuple[float, ...] = quantity(
        (0.0, -0.13761843, 1.79340966, 0.0, -1.65579123, 0.0), "rad", -6.2832, 6.2832
    )
    rotor: Rotor = Rotor()


@dataclass(frozen=True)
class Filter:
    """Kalman filters that make the state of the samples, and tell what disturbs the base.

    Samples pass as they are with `none`, and where they are exact and not believed to be late.
    """

    kind: str = choice("kalman", "none")
    # How late the base's samples are believed to be: so far the state is predicted.
    delay_s: float = quantity(0.0, "s", 0.0, 0.5)
    # What the noise of the samples is taken for. Little trust in velocity is trust in the model
    # where samples are later than they are believed to be.
    position_noise_m: float = quantity(0.002, "m", 1e-6, 1.0)
    velocity_noise_m_s: float = quantity(0.1, "m/s", 1e-6, 10.0)
    attitude_noise_rad: float = quantity(0.0035, "rad", 1e-6, 0.2)
    rate_noise_rad_s: float = quantity(0.01, "rad/s", 1e-6, 10.0)
    joint_noise_rad: float = quantity(0.0009, "rad", 1e-6, 0.2)
    # How fast disturbances of the base's motion and rotation change, per square root of a second.
    disturbance_m_s3: float = quantity(0.2, "m/s^2/sqrt(s)", 1e-3, 1e3)
    disturbance_rad_s3: float = quantity(3.0, "rad/s^2/sqrt(s)", 1e-3, 1e4)


@dataclass(frozen=True)
class Supervisor:
    """When it gives up what: how long a fault lasts, or how much it is, before a mode is asked for.

    The conditions themselves stand in `aerodrake.model.supervision.conditions`.
    """

    # Ticks that an MPC without an answer goes on with its last plan.
    plan_ticks: int = quantity(5, "ticks", 1, 1000)
    # Without an answer for so long it lands.
    plan_lost_s: float = quantity(5.0, "s", 0.02, 3600.0)
    # Outages of samples, from the last one that was taken in: how long the task goes on by
    # prediction alone, and how long the flight does.
    position_outage_s: float = quantity(0.3, "s", 0.02, 60.0)
    position_lost_s: float = quantity(1.5, "s", 0.02, 60.0)
    attitude_outage_s: float = quantity(0.2, "s", 0.02, 60.0)
    attitude_lost_s: float = quantity(0.4, "s", 0.02, 60.0)
    joints_outage_s: float = quantity(0.15, "s", 0.02, 60.0)
    joints_lost_s: float = quantity(1.0, "s", 0.02, 60.0)
    # What has asked for a mode must be over for so long.
    clear_s: float = quantity(0.5, "s", 0.0, 60.0)
    max_tilt_rad: float = quantity(1.0472, "rad", 0.1, 1.0472)
    # A rotor that gives less than this share of its thrust is lost.
    rotor_lost: float = quantity(0.45, "1", 0.0, 1.0)
    # A reference is refused that is lower, further from the start, or faster along an axis.
    lowest_m: float = quantity(0.1, "m", -1000.0, 1000.0)
    farthest_m: float = quantity(50.0, "m", 0.1, 10_000.0)
    fastest_m_s: float = quantity(1.5, "m/s", 0.01, 100.0)
    descend_m_s: float = quantity(0.3, "m/s", 0.05, 2.0)


@dataclass(frozen=True)
class Flight:
    """ESO-based flight controller; gains are per unit mass and inertia."""

    # What the base setpoint consists of: (p_d, v_d, a_d), or p_d alone as in the paper.
    interface: str = choice("trajectory", "position")
    position_gain: tuple[float, ...] = quantity((9.0, 9.0, 9.0), "1/s^2", 0.0, 400.0, length=3)
    velocity_gain: tuple[float, ...] = quantity((5.0, 5.0, 5.0), "1/s", 0.0, 100.0, length=3)
    integral_gain: tuple[float, ...] = quantity((0.0, 0.0, 0.0), "1/s^3", 0.0, 400.0, length=3)
    # About the base's roll, pitch and yaw axes.
    attitude_gain: tuple[float, ...] = quantity(
        (144.0, 144.0, 36.0), "1/s^2", 0.0, 1000.0, length=3
    )
    rate_gain: tuple[float, ...] = quantity((24.0, 24.0, 12.0), "1/s", 0.0, 200.0, length=3)
    position_eso_rad_s: float = quantity(3.0, "rad/s", 0.1, 100.0)
    attitude_eso_rad_s: float = quantity(15.0, "rad/s", 0.1, 100.0)
    # Of omega_d, the rate at which the desired attitude turns.
    rate_filter_s: float = quantity(0.03, "s", 0.0, 1.0)
    # What moving the arm takes: told by inverse dynamics, or found out by the observers, which
    # stands a little more delay and noise, and holds the base less still.
    feedforward: str = choice("whole_body", "none")
    max_tilt_rad: float = quantity(0.6, "rad", 0.05, 1.2)


@dataclass(frozen=True)
class Arm:
    """Joint PID; gains follow from bandwidth and damping by each joint's inertia."""

    bandwidth_rad_s: float = quantity(40.0, "rad/s", 1.0, 200.0)
    damping: float = quantity(1.0, "1", 0.1, 5.0)
    # Integral action: how fast a constant torque error is taken out.
    integral_rad_s: float = quantity(5.0, "rad/s", 0.0, 50.0)


@dataclass(frozen=True)
class Model:
    """The equivalent model of the base under its flight controller."""

    # flight: the closed loop as its gains make it. The others know of it K_B alone.
    kind: str = choice("flight", "velocity_aware", "paper", "exact", "integral")
    # K_B for the flight interface and gains of this scenario. The default is for theirs.
    # Identified: aerodrake identify hover
    k_b: tuple[float, ...] = quantity((1.71, 1.71, 1.71), "1/s", 0.01, 50.0, length=3)


@dataclass(frozen=True)
class Residual:
    """Residual velocity Delta: network, and online learning of its last layer."""

    mode: str = choice("off", "offline", "online")
    # Empty: an untrained network, whose output is zero until it learns online.
    checkpoint: str = file()
    learning_rate: float = quantity(0.0015, "1", 0.0, 1.0)
    batch: int = quantity(20, "samples", 1, 1000)
    # Guards of online learning. Bounds of 0 do not bound: with all of them 0 and
    # freeze_saturated false the last layer learns as the paper prints it. The _paper scenarios
    # then see steps of theta up to 0.0011, drifts from the offline layer up to 0.03 and errors
    # of that layer up to 0.27 m/s; at ten times their learning rate, 0.006, 0.12 and 0.27.
    max_step: float = quantity(0.01, "m/s", 0.0, 100.0)
    max_drift: float = quantity(0.3, "m/s", 0.0, 100.0)
    max_error_m_s: float = quantity(0.5, "m/s", 0.0, 100.0)
    freeze_saturated: bool = True
    # Delta is used while it has helped to predict, in means over so long; 0: always. Samples
    # whose velocity is off what position does, by so much in the mean, are poisoned; 0: none is.
    judge_s: float = quantity(1.0, "s", 0.0, 60.0)
    max_offset_m_s: float = quantity(0.005, "m/s", 0.0, 100.0)


@dataclass(frozen=True)
class Weights:
    """K_e, and diagonals of W_1, W_2,0, W_3 and W_4,0. Joint values: one, or one per joint."""

    # K_e of the desired end-effector velocity.
    k_e: tuple[float, ...] = quantity((16.0, 16.0, 16.0), "1/s", 0.0, 50.0, length=3)
    w_1: tuple[float, ...] = quantity((1e4, 1e4, 1e4), "1", 0.0, 1e8, length=3)
    w_2_base: tuple[float, ...] = quantity((1e-4, 1e-4, 1e-4), "1", 0.0, 1e6, length=3)
    w_2_joints: tuple[float, ...] = quantity((1.0,), "1", 0.0, 1e6)
    w_3_base: tuple[float, ...] = quantity((30.0, 30.0, 30.0), "1", 1e-3, 1e6, length=3)
    w_3_joints: tuple[float, ...] = quantity((3.0,), "1", 1e-3, 1e6)
    w_4: tuple[float, ...] = quantity((3000.0, 3000.0, 3000.0), "1", 0.0, 1e6, length=3)


@dataclass(frozen=True)
class Mpc(Weights):
    """Horizon, weights and bounds of the MPC. Joint limits come from the robot."""

    horizon: int = quantity(15, "stages", 2, 200)
    # How far they reach: stages last longer the further away they are, one tick at least.
    span_ticks: int = quantity(100, "ticks", 1, 1000)
    # The correction K_e e_E never asks for more than this: a far target is flown to, not lunged at.
    approach_speed_m_s: float = quantity(0.8, "m/s", 0.01, 100.0)
    # e_E along the horizon: predicted with the linearised p_E, or held as printed.
    error: str = choice("predicted", "frozen")
    # W_5 on changes of the base's acceleration from one stage to the next.
    w_5: tuple[float, ...] = quantity((3000.0, 3000.0, 3000.0), "1", 0.0, 1e6, length=3)
    # Of the orientation task: W_6, K_o, and the rate above which the tool is not turned to it.
    w_6: float = quantity(100.0, "1", 0.0, 1e8)
    k_o: float = quantity(8.0, "1/s", 0.0, 50.0)
    approach_speed_rad_s: float = quantity(0.8, "rad/s", 0.01, 100.0)
    # J_u xi_u': none, the base's own tilt predicted by flatness, or as measured and held.
    tilt: str = choice("flatness", "none", "held")
    base_velocity_m_s: tuple[float, ...] = quantity((1.5, 1.5, 1.5), "m/s", 0.01, 20.0, length=3)
    base_acceleration_m_s2: tuple[float, ...] = quantity(
        (2.5, 2.5, 2.5), "m/s^2", 0.1, 20.0, length=3
    )
    max_iterations: int = quantity(200, "iterations", 25, 100_000)


@dataclass(frozen=True)
class Clik:
    """Closed-loop inverse kinematics, in the MPC's place: K_e, speeds and bounds are the MPC's."""

    # lambda of the damped least squares, where the least of the weights is 1.
    damping: float = quantity(0.02, "1", 1e-4, 10.0)
    # How fast the arm returns to the centre of its learning space while the base makes up for it.
    centring_1_s: float = quantity(4.0, "1/s", 0.0, 50.0)
    # Of the first-order loop from wanted to commanded velocity; 1 / period is deadbeat.
    bandwidth_1_s: float = quantity(15.0, "1/s", 0.1, 500.0)


@dataclass(frozen=True)
class Baseline(Weights):
    """K_e and weights of the integral model at its own best.

    `aerodrake compare` flies them as `integral_best`. Found by diagrams/search_weights.py.
    """


@dataclass(frozen=True)
class Allocation:
    """Weight allocation: gamma, its boundaries and its gains."""

    # Weights by gamma, or fixed: those of `fixed_gamma` at d_o = d_h / 2, wherever the tool is.
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
    # d_o as w_d sees it is no smaller, so that J_4 never vanishes.
    d_o_floor_m: float = quantity(0.01, "m", 1e-4, 1.0)
    learning_space_m: tuple[float, ...] = quantity((0.15, 0.15, 0.10), "m", 0.01, 10.0, length=3)


@dataclass(frozen=True)
class Scenario:
    """One flight, reproducible from this alone."""

    # Defaults to the file's name.
    name: str = dataclasses.field(default="")
    duration: float = quantity(30.0, "s", 0.02, 3600.0)
    # Hover before reference time 0.
    settle_s: float = quantity(3.0, "s", 0.0, 60.0)
    seed: int = quantity(0, "1", 0, 2**31 - 1)
    rates: Rates = Rates()
    reference: Reference = Hover()
    # Where the tool points; its axis is -z of the frame `tool`.
    orientation: Orientation = OrientationOff()
    vehicle: Vehicle = Vehicle()
    sensors: Sensors = Sensors()
    filter: Filter = Filter()
    wind: Wind = Wind()
    payload: Payload = Payload()
    mismatch: Mismatch = Mismatch()
    # What breaks on the way.
    faults: tuple[AnyFault, ...] = several()
    flight: Flight = Flight()
    arm: Arm = Arm()
    model: Model = Model()
    residual: Residual = Residual()
    controller: str = choice("mpc", "clik")
    mpc: Mpc = Mpc()
    clik: Clik = Clik()
    baseline: Baseline = Baseline()
    allocation: Allocation = Allocation()
    supervisor: Supervisor = Supervisor()
    # The file this was read from, for messages.
    source: str = provenance()

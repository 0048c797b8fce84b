"""A scenario: the sections of one flight, and the rules between its keys."""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from aerodrake.scenario.actuation import Actuation
from aerodrake.scenario.environment import Air, Mismatch, Payload, Physics, Wind
from aerodrake.scenario.faults import SAMPLE_GROUPS, AnyFault, MpcFault
from aerodrake.scenario.references import (
    SHORTEST_AXIS,
    AxisAlong,
    FixedAxis,
    Hover,
    Orientation,
    OrientationOff,
    Reference,
    Waypoints,
)
from aerodrake.scenario.residual import Residual
from aerodrake.scenario.schema import (
    Section,
    assign_keys,
    choice,
    map_files,
    provenance,
    quantity,
)
from aerodrake.scenario.sections import (
    Allocation,
    Arm,
    Clik,
    Filter,
    Flight,
    Model,
    Mpc,
    Rates,
    Supervisor,
    Vehicle,
)
from aerodrake.scenario.sensors import Sensors
from aerodrake.support.errors import ScenarioError, sourced
from aerodrake.support.limits import SEED

MAX_NAME_BYTES = 200
"""Longest name of a scenario, which is part of a folder's name."""


@dataclass(frozen=True)
class Scenario(Section):
    """All data of one flight; equal scenarios give equal flights.

    A scenario is valid, whichever way it is built: each value as declared by its section, and all
    of them consistent with each other. Paths are absolute.

    Raises:
        ScenarioError: if a value is invalid, or the first rule of `RULES` is violated, with the
            scenario's name and the dotted key.
    """

    # Name in results and messages; empty for the name of the file.
    name: str = dataclasses.field(default="")
    # Reference time to fly.
    duration: float = quantity(30.0, "s", 0.02, 3600.0)
    # Duration of the initial hover, before reference time 0.
    settle_s: float = quantity(3.0, "s", 0.0, 60.0)
    seed: int = quantity(0, "1", *SEED)
    rates: Rates = Rates()
    reference: Reference = Hover()
    # Desired direction of the tool's axis, which is -z of the frame `tool`.
    orientation: Orientation = OrientationOff()
    vehicle: Vehicle = Vehicle()
    physics: Physics = Physics()
    sensors: Sensors = Sensors()
    filter: Filter = Filter()
    wind: Wind = Wind()
    air: Air = Air()
    actuation: Actuation = Actuation()
    payload: Payload = Payload()
    mismatch: Mismatch = Mismatch()
    # Faults to inject.
    faults: tuple[AnyFault, ...] = ()
    flight: Flight = Flight()
    arm: Arm = Arm()
    model: Model = Model()
    residual: Residual = Residual()
    controller: str = choice("mpc", "clik")
    mpc: Mpc = Mpc()
    clik: Clik = Clik()
    allocation: Allocation = Allocation()
    supervisor: Supervisor = Supervisor()
    # The file that the scenario was read from, for messages.
    source: str = provenance()

    def __post_init__(self) -> None:
        """Converts and checks all values, and the rules between them."""
        with sourced(self.name):
            super().__post_init__()
            for name in vars(self):
                section = map_files(getattr(self, name), Path.absolute)
                object.__setattr__(self, name, section)
            for rule in RULES:
                for key, message in rule(self):
                    raise ScenarioError("", key, message)


assign_keys(Scenario)

Violation = tuple[str, str]
"""Dotted key and what was expected."""


def _rates(scenario: Scenario) -> Iterator[Violation]:
    rates = scenario.rates
    times = {f"rates.{name}": value for name, value in dataclasses.asdict(rates).items()}
    times |= scenario.sensors.times
    times["actuation.rotor_dead_time_s"] = scenario.actuation.rotor_dead_time_s
    times["filter.delay_s"] = scenario.filter.delay_s
    pairs = [(key, "rates.plant_step_s") for key in times if key != "filter.delay_s"]
    pairs += [
        ("filter.delay_s", "rates.sensor_period_s"),
        ("rates.mpc_period_s", "rates.sensor_period_s"),
        ("rates.mpc_period_s", "rates.flight_period_s"),
    ]
    for key, base in pairs:
        count = times[key] / times[base]
        if abs(count - round(count)) > 1e-6:
            yield key, f"expected a multiple of {base} ({times[base]:g} s), got {times[key]:g} s"
    if rates.flight_period_s < rates.sensor_period_s - 1e-9:
        expected = f"expected rates.sensor_period_s ({rates.sensor_period_s:g} s) or more, since "
        got = f"the observers take one new sample a tick; got {rates.flight_period_s:g} s"
        yield "rates.flight_period_s", expected + got


def _sensors(scenario: Scenario) -> Iterator[Violation]:
    """Yields inconsistent values, and samples too rare for the supervisor or for the filter."""
    sensors, supervisor = scenario.sensors, scenario.supervisor
    joints = sensors.joints
    if joints.rate == "exact" and joints.rate_filter_s > 0:
        expected = "expected 0 s, since sensors.joints.rate is exact"
        yield "sensors.joints.rate_filter_s", f"{expected}; got {joints.rate_filter_s:g} s"
    for group in SAMPLE_GROUPS:
        outage_s, period_s = getattr(supervisor, f"{group}_outage_s"), sensors.each[group].period_s
        if period_s >= outage_s:
            expected = f"expected less than supervisor.{group}_outage_s ({outage_s:g} s)"
            yield f"sensors.{group}.period_s", f"{expected}, got {period_s:g} s"
    if scenario.filter.accelerometer_noise_m_s2 > 0 and sensors.accelerometer.period_s == 0:
        expected = "expected 0, since there is no accelerometer (sensors.accelerometer.period_s 0)"
        got = f"got {scenario.filter.accelerometer_noise_m_s2:g} m/s^2"
        yield "filter.accelerometer_noise_m_s2", f"{expected}; {got}"


def _name(scenario: Scenario) -> Iterator[Violation]:
    name = scenario.name
    if set(name) & {*"/\\"} or name.startswith("."):
        yield "name", f"expected a valid folder name, got '{name}'"
    if len(name.encode()) > MAX_NAME_BYTES:
        yield "name", f"expected {MAX_NAME_BYTES} bytes or less, got '{name:.20}...'"


def _reference(scenario: Scenario) -> Iterator[Violation]:
    reference, orientation = scenario.reference, scenario.orientation
    if isinstance(reference, Waypoints) and not reference.file:
        yield "reference.file", "expected the path of a CSV file t,x,y,z"
    if isinstance(orientation, FixedAxis) and math.hypot(*orientation.axis) < SHORTEST_AXIS:
        expected = f"expected a direction, of length {SHORTEST_AXIS:g} or more"
        yield "orientation.axis", f"{expected}, got {list(orientation.axis)}"
    if isinstance(orientation, AxisAlong) and not orientation.file:
        yield "orientation.file", "expected the path of a CSV file t,ax,ay,az"


def _rotor(scenario: Scenario) -> Iterator[Violation]:
    low, high = scenario.vehicle.rotor.min_thrust_n, scenario.vehicle.rotor.max_thrust_n
    if low >= high:
        message = f"expected less than max_thrust_n ({high:g} N), got {low:g} N"
        yield "vehicle.rotor.min_thrust_n", message


def _air(scenario: Scenario) -> Iterator[Violation]:
    if scenario.air.ceiling_m and not scenario.air.rotor_radius_m:
        expected = f"air.ceiling_m ({scenario.air.ceiling_m:g} m) expects more than 0 m"
        yield "air.rotor_radius_m", f"{expected}, got 0 m"


def _wind(scenario: Scenario) -> Iterator[Violation]:
    wind = scenario.wind
    if any(wind.wave_m_s) and not any(wind.wave_rad_m):
        expected = f"wind.wave_m_s ({list(wind.wave_m_s)} m/s) expects a wave number other than 0"
        yield "wind.wave_rad_m", f"{expected}, got {list(wind.wave_rad_m)} rad/m"


def _latencies(scenario: Scenario) -> Iterator[Violation]:
    sensors = scenario.sensors.each
    bounds = {f"sensors.{name}.latency_s": sensor.latency_s for name, sensor in sensors.items()}
    bounds["actuation.setpoint_latency_s"] = scenario.actuation.setpoint_latency_s
    for key, (low, high) in bounds.items():
        if low > high:
            expected = "expected the least latency, then the largest, in s"
            yield key, f"{expected}, got [{low:g}, {high:g}]"


def _physics(scenario: Scenario) -> Iterator[Violation]:
    """Yields keys of MuJoCo that a scenario with Drake sets."""
    physics, default = scenario.physics, Physics()
    if physics.engine == "mujoco":
        return
    for key in ("integrator", "substeps"):
        if (got := getattr(physics, key)) != (only := getattr(default, key)):
            expected = f"expected {only} with physics.engine {physics.engine}"
            yield f"physics.{key}", f"{expected}; others are of engine mujoco; got {got}"


def _model(scenario: Scenario) -> Iterator[Violation]:
    interface = scenario.flight.interface
    if scenario.model.kind == "velocity_aware" and interface != "trajectory":
        expected = "velocity_aware expects flight.interface trajectory, which includes v_d"
        yield "model.kind", f"{expected}; got '{interface}'"


def _clik(scenario: Scenario) -> Iterator[Violation]:
    """Yields keys that `controller: clik`, which has no MPC, does not support."""
    if scenario.controller != "clik":
        return
    orientation = scenario.orientation
    if not isinstance(orientation, OrientationOff):
        yield "orientation.kind", f"controller clik expects off, got '{orientation.kind}'"
    for i, fault in enumerate(scenario.faults):
        if isinstance(fault, MpcFault):
            expected = "controller clik expects no fault of the MPC"
            yield f"faults[{i}].kind", f"{expected}, got '{fault.kind}'"
    for key in ("k_q", "k_m"):
        if getattr(scenario.allocation, key) == 0:
            yield f"allocation.{key}", "controller clik expects a weight above 0, got 0"


def _supervisor(scenario: Scenario) -> Iterator[Violation]:
    """Yields durations with which the vehicle would land, or stop, before it holds."""
    config = scenario.supervisor
    for group in SAMPLE_GROUPS:
        outage, lost = getattr(config, f"{group}_outage_s"), getattr(config, f"{group}_lost_s")
        if lost <= outage:
            message = f"expected more than {group}_outage_s ({outage:g} s), got {lost:g} s"
            yield f"supervisor.{group}_lost_s", message
    plan_s = config.plan_ticks * scenario.rates.mpc_period_s
    if config.plan_lost_s <= plan_s:
        expected = f"expected more than the duration of plan_ticks ({plan_s:g} s)"
        yield "supervisor.plan_lost_s", f"{expected}, got {config.plan_lost_s:g} s"


def _allocation(scenario: Scenario) -> Iterator[Violation]:
    hover = scenario.allocation.d_h_m
    for key in ("d_edge_m", "d_f_m"):
        distance = getattr(scenario.allocation, key)
        if distance <= hover:
            yield f"allocation.{key}", f"expected more than d_h_m ({hover:g} m), got {distance:g} m"


RULES = (
    *(_rates, _sensors, _latencies, _name, _reference, _rotor, _physics, _wind, _air),
    *(_model, _clik, _supervisor, _allocation),
)

"""Rules between the keys of a scenario."""

import dataclasses
import math
from collections.abc import Iterator

from aerodrake.scenario.faults import SAMPLE_GROUPS, LearnerFault, MpcFault, MpcStarved
from aerodrake.scenario.references import AxisAlong, FixedAxis, OrientationOff, Waypoints
from aerodrake.scenario.residual import Guards, Residual
from aerodrake.scenario.sections import Allocation, Scenario
from aerodrake.support.errors import ScenarioError

MAX_NAME_BYTES = 200
"""Longest name of a scenario, which is part of a folder's name."""

SHORTEST_AXIS = 1e-3
"""Length below which a vector has no direction."""

Violation = tuple[str, str]
"""Dotted key and what was expected."""


def check(scenario: Scenario, source: object) -> None:
    """Checks that the keys of a scenario are consistent with each other.

    Args:
        scenario: Scenario whose keys are valid by themselves.
        source: Named in errors: the file, and the options on top of it.

    Raises:
        ScenarioError: on the first rule of `RULES` that is violated.
    """
    for rule in RULES:
        for key, message in rule(scenario):
            raise ScenarioError(source, key, message)


def _rates(scenario: Scenario) -> Iterator[Violation]:
    rates = scenario.rates
    times = {f"rates.{name}": value for name, value in dataclasses.asdict(rates).items()}
    times["sensors.base_delay_s"] = scenario.sensors.base_delay_s
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


RULES = (_rates, _name, _reference, _rotor, _model, _clik, _supervisor, _allocation)


def warnings(scenario: Scenario) -> list[str]:
    """Returns notes on values that are valid but may degrade the flight."""
    notes = []
    half_height = scenario.allocation.learning_space_m[2] / 2
    as_in_the_paper = Allocation()
    if scenario.allocation.d_h_m > half_height and not (
        scenario.allocation.d_h_m == as_in_the_paper.d_h_m
        and scenario.allocation.learning_space_m == as_in_the_paper.learning_space_m
    ):
        notes.append(
            f"allocation.d_h_m ({scenario.allocation.d_h_m:g} m) exceeds half the height of the "
            f"learning space ({half_height:g} m)"
        )
    if scenario.model.kind in ("paper", "exact") and scenario.flight.interface == "trajectory":
        notes.append(
            f"model.kind {scenario.model.kind} is for flight.interface position; with "
            "flight.interface trajectory it predicts a lag that the base does not have"
        )
    if scenario.mpc.tilt == "held":
        notes.append("mpc.tilt held, the paper's form, destabilises the loop at high gains")
    if scenario.residual.as_printed:
        notes += [
            f"residual.as_printed: residual.{key} is not used"
            for key in Guards._fields
            if getattr(scenario.residual, key)
            not in (getattr(Residual, key), getattr(Guards(), key))
        ]
    if scenario.residual.mode == "off":
        notes += [
            f"faults[{i}] {fault.kind} has no effect: residual.mode off has no learner"
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, LearnerFault)
        ]
    if (solver := scenario.mpc.solver) not in ("osqp", "active_set"):
        notes += [
            f"faults[{i}] {fault.kind}: mpc.solver {solver} has its own limit of iterations"
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, MpcStarved)
        ]
    return notes

"""What no single key of a scenario can tell: whether they fit each other."""

from __future__ import annotations

import dataclasses
import math

from aerodrake.scenario.faults import MPC_FAULTS, SAMPLE_GROUPS, LearnerFault
from aerodrake.scenario.references import AxisAlong, FixedAxis, OrientationOff, Waypoints
from aerodrake.scenario.sections import Scenario
from aerodrake.support.errors import ScenarioError

MAX_NAME_BYTES = 200
"""A scenario's name, which is part of that of a folder, is no longer."""

SHORTEST_AXIS = 1e-3
"""What is shorter has no direction."""


def check(scenario: Scenario, source: object) -> None:
    """Refuses what cannot be flown.

    Args:
        scenario: Whose keys are valid one by one.
        source: Named in errors: the file, and the options on top of it.

    Raises:
        ScenarioError: where keys contradict each other.
    """
    for field in dataclasses.fields(scenario.rates):
        _check_steps(scenario, source, f"rates.{field.name}", getattr(scenario.rates, field.name))
    _check_steps(scenario, source, "sensors.base_delay_s", scenario.sensors.base_delay_s)
    late = scenario.filter.delay_s / scenario.rates.sensor_period_s
    if abs(late - round(late)) > 1e-6:
        raise ScenarioError(
            source,
            "filter.delay_s",
            f"expected a multiple of rates.sensor_period_s ({scenario.rates.sensor_period_s:g} s), "
            f"got {scenario.filter.delay_s:g} s",
        )
    for key in ("sensor_period_s", "flight_period_s"):
        ticks = scenario.rates.mpc_period_s / getattr(scenario.rates, key)
        if abs(ticks - round(ticks)) > 1e-6:
            raise ScenarioError(
                source,
                "rates.mpc_period_s",
                f"expected a multiple of rates.{key} ({getattr(scenario.rates, key):g} s), "
                f"got {scenario.rates.mpc_period_s:g} s",
            )
    if scenario.rates.flight_period_s < scenario.rates.sensor_period_s - 1e-9:
        raise ScenarioError(
            source,
            "rates.flight_period_s",
            f"expected rates.sensor_period_s ({scenario.rates.sensor_period_s:g} s) or more, since "
            f"each tick takes its sample as new; got {scenario.rates.flight_period_s:g} s",
        )
    if set(scenario.name) & {*"/\\"} or scenario.name.startswith("."):
        raise ScenarioError(
            source, "name", f"expected a name that can be a folder's, got '{scenario.name}'"
        )
    if len(scenario.name.encode()) > MAX_NAME_BYTES:
        raise ScenarioError(
            source, "name", f"expected {MAX_NAME_BYTES} bytes or less, got '{scenario.name:.20}...'"
        )
    if isinstance(scenario.reference, Waypoints) and not scenario.reference.file:
        raise ScenarioError(source, "reference.file", "expected the path of a CSV file t,x,y,z")
    _check_orientation(scenario, source)
    if scenario.vehicle.rotor.min_thrust_n >= scenario.vehicle.rotor.max_thrust_n:
        raise ScenarioError(
            source,
            "vehicle.rotor.min_thrust_n",
            f"expected less than max_thrust_n ({scenario.vehicle.rotor.max_thrust_n:g} N), "
            f"got {scenario.vehicle.rotor.min_thrust_n:g} N",
        )
    if scenario.model.kind == "velocity_aware" and scenario.flight.interface != "trajectory":
        raise ScenarioError(
            source,
            "model.kind",
            "velocity_aware expects flight.interface trajectory, since a base that is "
            f"not told v_d cannot follow it; got '{scenario.flight.interface}'",
        )
    for i, fault in enumerate(scenario.faults):
        if scenario.controller == "clik" and isinstance(fault, MPC_FAULTS):
            message = f"controller clik expects no fault of the MPC, got '{fault.kind}'"
            raise ScenarioError(source, f"faults[{i}].kind", message)
    _check_supervisor(scenario, source)
    allocation = scenario.allocation
    for key in ("k_q", "k_m"):
        if scenario.controller == "clik" and getattr(allocation, key) == 0:
            raise ScenarioError(
                source,
                f"allocation.{key}",
                "controller clik expects more than 0, as a weight; got 0",
            )
    for key, low, high in (
        ("d_edge_m", allocation.d_h_m, allocation.d_edge_m),
        ("d_f_m", allocation.d_h_m, allocation.d_f_m),
    ):
        if high <= low:
            message = f"expected more than d_h_m ({low:g} m), got {high:g} m"
            raise ScenarioError(source, f"allocation.{key}", message)


def _check_supervisor(scenario: Scenario, source: object) -> None:
    """What is ridden out must be given up later than the task is."""
    own = scenario.supervisor
    pairs = [(f"{group}_outage_s", f"{group}_lost_s") for group in SAMPLE_GROUPS]
    plan_s = own.plan_ticks * scenario.rates.mpc_period_s
    for early, late in pairs:
        if getattr(own, late) <= getattr(own, early):
            raise ScenarioError(
                source,
                f"supervisor.{late}",
                f"expected more than {early} ({getattr(own, early):g} s), "
                f"got {getattr(own, late):g} s",
            )
    if own.plan_lost_s <= plan_s:
        raise ScenarioError(
            source,
            "supervisor.plan_lost_s",
            f"expected more than plan_ticks last ({plan_s:g} s), got {own.plan_lost_s:g} s",
        )


def _check_steps(scenario: Scenario, source: object, key: str, time: float) -> None:
    step = scenario.rates.plant_step_s
    if abs(time / step - round(time / step)) > 1e-6:
        raise ScenarioError(
            source,
            key,
            f"expected a multiple of rates.plant_step_s ({step:g} s), got {time:g} s",
        )


def _check_orientation(scenario: Scenario, source: object) -> None:
    orientation = scenario.orientation
    if isinstance(orientation, FixedAxis) and math.hypot(*orientation.axis) < SHORTEST_AXIS:
        raise ScenarioError(
            source,
            "orientation.axis",
            f"expected a direction, of length {SHORTEST_AXIS:g} or more, "
            f"got {list(orientation.axis)}",
        )
    if isinstance(orientation, AxisAlong) and not orientation.file:
        raise ScenarioError(
            source, "orientation.file", "expected the path of a CSV file t,ax,ay,az"
        )
    if scenario.controller == "clik" and not isinstance(orientation, OrientationOff):
        raise ScenarioError(
            source, "orientation.kind", f"controller clik expects off, got '{orientation.kind}'"
        )


def warnings(scenario: Scenario) -> list[str]:
    """What is valid and flown as asked, but should be known."""
    found = []
    half_height = scenario.allocation.learning_space_m[2] / 2
    if scenario.allocation.d_h_m > half_height:
        found.append(
            f"allocation.d_h_m ({scenario.allocation.d_h_m:g} m) reaches out of the learning "
            f"space, whose half height is {half_height:g} m, as in the paper"
        )
    if scenario.model.kind in ("paper", "exact") and scenario.flight.interface == "trajectory":
        found.append(
            f"model.kind {scenario.model.kind} is for a base that is told p_d alone; with "
            "flight.interface trajectory it predicts a lag that is not there"
        )
    if scenario.mpc.tilt == "held":
        found.append("mpc.tilt held, the paper's form, destabilises the loop at high gains")
    if scenario.residual.mode == "off":
        found += [
            f"faults[{i}] {fault.kind} does nothing: residual.mode off has no learner"
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, LearnerFault)
        ]
    return found

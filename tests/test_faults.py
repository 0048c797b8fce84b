"""Tests that fly each row of the tables in `diagrams/faults.md`."""

import re
import typing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml

from aerodrake.flight.events import events
from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.supervision.conditions import NEVER, Condition, conditions
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import AnyFault, Scenario
from aerodrake.scenario.load import load_with_options

PAGE = (Path(__file__).parents[1] / "diagrams" / "faults.md").read_text()
SETTLE_S = 0.5
RECOVERY_S, LANDING_S = 3.0, 14.0
"""s, flight time after a fault has ended, and of a flight that lands."""

FINAL_ERROR_M = 0.005
"""Largest error of the end-effector at the end of a completed flight."""


@dataclass(frozen=True)
class Row:
    """One row of a table: a fault, the exit reason, and the active conditions."""

    fault: str
    ends: str
    conditions: tuple[str, ...]


def rows() -> list[Row]:
    """Returns the rows with a fault of all tables."""
    rows = []
    for line in PAGE.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if cells[0].startswith("`{kind:"):
            fault, _, _, ends, active = cells
            rows.append(Row(fault.strip("`"), ends, tuple(active.split())))
    return rows


ROWS = rows()


def scenario_of(row: Row) -> Scenario:
    """Returns a flight with a row's fault, long enough for recovery or landing."""
    fault = yaml.safe_load(row.fault)
    end = fault["start_s"] + min(fault["duration_s"], 3.0)
    duration = LANDING_S if row.ends == "landed" else end + RECOVERY_S
    name = "clover_position" if fault["kind"].startswith("learner") else "clover"
    options = [f"faults=[{row.fault}]", f"settle_s={SETTLE_S}", f"duration={duration}"]
    return load_with_options(name, [("--set", option) for option in options])


@pytest.fixture(scope="module", params=ROWS, ids=lambda row: row.fault)
def flown(request) -> tuple[Row, Scenario, FlightLog]:
    scenario = scenario_of(request.param)
    return request.param, scenario, FlightSimulation(scenario).fly()


def test_each_row_of_the_table(flown):
    row, scenario, log = flown
    active = {event["cause"] for event in events(scenario, log)}
    assert (log.exit_reason, active) == (row.ends, set(row.conditions) | active & OPTIONAL)
    for key in log.signals:
        assert np.isfinite(log[key]).all(), key
    limits = SetpointLimits.make(scenario.mpc, VehicleModel.load(scenario))
    check_envelope(log, limits)
    if row.ends == "completed":
        moved = np.linalg.norm(log["position_offset_m"][-1])
        assert log.error_m[-1] - moved < FINAL_ERROR_M + tracking_error_m(scenario)


OPTIONAL = {"saturated"}
"""Conditions that may be active beside those of a row."""


def tracking_error_m(scenario: Scenario) -> float:
    """Returns the tracking error without a fault: a few millimetres with the paper's interface."""
    return 0.005 if scenario.flight.interface == "position" else 0.0


def check_envelope(log: FlightLog, limits: SetpointLimits) -> None:
    """Asserts that setpoints keep their limits without jumps, and joints to half a degree.

    A reset of the estimated position moves setpoint and estimate alike.
    """
    p = np.hstack([log["p_Bd_m"] - log["position_offset_m"], log["q_d_rad"]])
    v = np.hstack([log["v_Bd_m_s"], log["qdot_d_rad_s"]])
    dt = np.diff(log.time_s)[:, None]
    assert np.all(np.abs(v) <= limits.velocity + 1e-6)
    assert np.all(np.abs(np.diff(v, axis=0)) <= limits.acceleration * dt + 1e-6)
    assert np.all(np.abs(np.diff(p, axis=0)) <= limits.velocity * dt + 1e-6)
    half_a_degree = np.radians(0.5)
    assert np.all(log["q_rad"] <= limits.upper[3:] + half_a_degree)
    assert np.all(log["q_rad"] >= limits.lower[3:] - half_a_degree)


def test_every_kind_of_fault_is_in_a_table():
    kinds = {kind.kind for kind in typing.get_args(AnyFault)}
    assert {yaml.safe_load(row.fault)["kind"] for row in ROWS} == kinds


def condition_row(condition: Condition) -> str:
    """Returns the row of a condition on the page."""
    clears = "never" if condition.clear_s == NEVER else f"<= {condition.clear:g}"
    if condition.clear_s not in (0, NEVER):
        clears += f" for {condition.clear_s:g} s"
    lasts = f" for {condition.trigger_s:g} s" if condition.trigger_s else ""
    return (
        f"| {condition.name} | {condition.signal.name} | {condition.mode.name} "
        f"| >= {condition.trigger:.4g}{lasts} | {clears} |"
    )


@pytest.mark.parametrize("condition", conditions(Scenario().supervisor), ids=lambda c: c.name)
def test_every_condition_is_on_the_page_with_its_thresholds(condition):
    assert condition_row(condition) in PAGE


def test_tests_named_on_the_page_exist():
    for path, name in re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE):
        source = (Path(__file__).parents[1] / path).read_text()
        assert re.search(rf"^def {name}\(", source, re.MULTILINE), f"{path}::{name}"

"""A scenario: rules between its keys."""

import re

import pytest

from aerodrake.scenario import Flight, Model, MpcStarved, Push, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput


def hover_with(changes: dict[str, object]) -> Scenario:
    """Returns the packaged hover with dotted keys overridden, checked once at the end."""
    return load_scenario("hover", changes)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"rates.plant_step_s": 0.003}, "rates.sensor_period_s: expected a multiple of"),
        ({"rates.sensor_period_s": 0.0105}, "rates.sensor_period_s: expected a multiple of"),
        ({"rates.flight_period_s": 0.0105}, "rates.flight_period_s: expected a multiple of"),
        ({"rates.arm_period_s": 0.0055}, "rates.arm_period_s: expected a multiple of"),
        ({"rates.mpc_period_s": 0.0205}, "rates.mpc_period_s: expected a multiple of"),
        (
            {"rates.plant_step_s": 0.005, "rates.arm_period_s": 0.002},
            "rates.arm_period_s: expected a multiple of rates.plant_step_s (0.005 s), got 0.002 s",
        ),
        (
            {"rates.sensor_period_s": 0.012},
            "rates.mpc_period_s: expected a multiple of rates.sensor_period_s (0.012 s), "
            "got 0.02 s",
        ),
        (
            {"rates.flight_period_s": 0.04},
            "rates.mpc_period_s: expected a multiple of rates.flight_period_s",
        ),
        (
            {"vehicle.rotor.min_thrust_n": 20.0},
            "vehicle.rotor.min_thrust_n: expected less than max_thrust_n (20 N), got 20 N",
        ),
        (
            {"rates.flight_period_s": 0.005},
            "rates.flight_period_s: expected rates.sensor_period_s (0.01 s) or more",
        ),
        (
            {"sensors.base_delay_s": 0.0105},
            "sensors.base_delay_s: expected a multiple of rates.plant_step_s (0.001 s), "
            "got 0.0105 s",
        ),
        (
            {"filter.delay_s": 0.015},
            "filter.delay_s: expected a multiple of rates.sensor_period_s (0.01 s), got 0.015 s",
        ),
        (
            {"filter.delay_s": 0.01, "rates.sensor_period_s": 0.02, "rates.flight_period_s": 0.02},
            "filter.delay_s: expected a multiple of rates.sensor_period_s (0.02 s), got 0.01 s",
        ),
        (
            {"actuation.rotor_dead_time_s": 0.0025},
            "actuation.rotor_dead_time_s: expected a multiple of rates.plant_step_s (0.001 s), "
            "got 0.0025 s",
        ),
        (
            {"actuation.setpoint_latency_s": [0.02, 0.01]},
            "actuation.setpoint_latency_s: expected the least latency, then the largest, in s, "
            "got [0.02, 0.01]",
        ),
        (
            {"wind.wave_m_s": [0.0, 1.0, 0.0]},
            "wind.wave_rad_m: wind.wave_m_s ([0.0, 1.0, 0.0] m/s) expects a wave number other "
            "than 0, got [0.0, 0.0, 0.0] rad/m",
        ),
        (
            {"air.ceiling_m": 2.0},
            "air.rotor_radius_m: air.ceiling_m (2 m) expects more than 0 m, got 0 m",
        ),
        ({"name": "../elsewhere"}, "name: expected a valid folder name"),
        (
            {"flight.interface": "position", "model.kind": "velocity_aware"},
            "model.kind: velocity_aware expects",
        ),
        (
            {"supervisor.joints_lost_s": 0.1},
            "supervisor.joints_lost_s: expected more than joints_outage_s (0.15 s), got 0.1 s",
        ),
        (
            {"supervisor.plan_lost_s": 0.1},
            "supervisor.plan_lost_s: expected more than the duration of plan_ticks (0.1 s), "
            "got 0.1 s",
        ),
        (
            {"controller": "clik", "allocation.k_m": 0},
            "allocation.k_m: controller clik expects a weight above 0, got 0",
        ),
        (
            {"controller": "clik", "faults": [Push(), MpcStarved()]},
            "faults[1].kind: controller clik expects no fault of the MPC, got 'mpc_starved'",
        ),
        (
            {"allocation.d_edge_m": 0.07},
            "allocation.d_edge_m: expected more than d_h_m (0.075 m), got 0.07 m",
        ),
        (
            {"allocation.d_f_m": 0.075},
            "allocation.d_f_m: expected more than d_h_m (0.075 m), got 0.075 m",
        ),
    ],
)
def test_an_inconsistent_key_is_named(changes, expected):
    with pytest.raises(BadInput, match=re.escape(f": {expected}")):
        hover_with(changes)


@pytest.mark.parametrize("kind", ["flight", "paper", "exact", "integral"])
def test_consistent_combinations_are_accepted(kind):
    scenario = hover_with(
        {
            "flight.interface": "position",
            "model.kind": kind,
            "mpc.tilt": "flatness",
            "rates.plant_step_s": 0.0005,
            "rates.sensor_period_s": 0.005,
            "rates.mpc_period_s": 0.03,
            "sensors.base_delay_s": 0.0105,
            "filter.delay_s": 0.015,
        }
    )
    assert scenario.flight == Flight(interface="position")
    assert scenario.model == Model(kind=kind)

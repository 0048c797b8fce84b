"""Arms with the traits of real ones fly with the defaults, and are lost with older ones."""

import pytest

from aerodrake.flight.events import events
from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import resolve
from tests.arms import DESIGNS, arm_scenario


def flown(scenario: Scenario) -> tuple[FlightLog, float]:
    """Returns the log of a flight, and its largest error in m."""
    log = FlightSimulation(scenario).fly()
    return log, summarize(scenario, log)["error"]["max_m"]


@pytest.mark.parametrize("name", DESIGNS)
def test_flies_with_the_defaults(name, tmp_path):
    scenario = arm_scenario(DESIGNS[name], tmp_path)
    log, error_m = flown(scenario)
    assert log.exit_reason == "completed" and error_m < 1.5e-4
    assert log["joint_oscillation_rad_s"].max() < 0.05
    effort = VehicleModel.load(scenario).effort
    assert (abs(log.signals["joint_torque_n_m"]) < 0.9 * effort).all()


@pytest.mark.parametrize(
    ("key", "value", "names"),
    [
        ("arm.inertia", "diagonal", ("light", "desktop", "offset")),
        ("flight.feedforward", "whole_body", ("long", "heavy", "continuous")),
    ],
)
def test_diverges_with_settings_that_neglect_coupling(key, value, names, tmp_path):
    """Joint gains of the diagonal inertia, or tilt for the arm's commanded acceleration."""
    for name in names:
        scenario = resolve(
            arm_scenario(DESIGNS[name], tmp_path), {key: value, "arm.bandwidth_rad_s": 40.0}
        )
        log, error_m = flown(scenario)
        assert log.exit_reason != "completed" or error_m > 5e-4, name
        # It is called what it is, although samples may be rejected.
        oscillation = log["joint_oscillation_rad_s"].max()
        assert oscillation > scenario.supervisor.joint_oscillation_rad_s, name
        assert "joints_outage" not in {event["cause"] for event in events(scenario, log)}, name

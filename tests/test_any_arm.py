"""Arms with the traits of real ones fly with the defaults, and are lost with older ones."""

from dataclasses import replace

import pytest

from aerodrake.analysis.analyze import analyze_hover
from aerodrake.flight.events import events
from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Filter, Rates, Scenario, Sensors
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


def test_the_reaction_of_an_arm_on_the_base_is_no_disturbance(tmp_path):
    """If it is estimated as one, the first joint and the base grow against each other at 1 Hz."""
    reaching = replace(
        DESIGNS["heavy"], mass_kg=(0.3, 1.2, 0.5), working_rad=(0.0, 0.8, -1.2), base_kg=3.0
    )
    default = replace(
        arm_scenario(reaching, tmp_path),
        rates=Rates(plant_step_s=0.0025),
        filter=Filter(delay_s=0.01, velocity_noise_m_s=0.02),
        sensors=Sensors(base_delay_s=0.01),
    )
    hover = analyze_hover(default)
    slow = [mode.damping for mode in hover.least_damped if 0.3 < mode.frequency_hz < 3.0]
    assert hover.is_stable and min(slow) > 0.1
    estimated = analyze_hover(resolve(default, {"flight.feedforward": "none"}))
    assert not estimated.is_stable and "joint_0 and x at 0.9 Hz grow" in estimated.sentence

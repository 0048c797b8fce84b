"""Notes on references that leave the envelope, before the flight."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.notes import scenario_notes
from aerodrake.model.reference.envelope_notes import SIZE_KEYS, SPEED_KEYS, envelope_notes
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clover, Lissajous, MovingTarget, Scenario, Supervisor, Waypoints
from aerodrake.scenario.load import load_scenario
from aerodrake.scenario.references import Reference

PACKAGED = ("clover", "hover", "moving_target", "figure_eight", "lissajous", "waypoints")


def notes_of(scenario):
    return envelope_notes(scenario, VehicleModel.load(scenario))


@pytest.mark.parametrize("name", PACKAGED)
def test_packaged_scenarios_have_no_note(name):
    assert notes_of(load_scenario(name)) == []


def test_every_kind_has_keys():
    kinds = {kind.kind for kind in Reference.__args__}
    assert SIZE_KEYS.keys() == kinds and SPEED_KEYS.keys() == kinds - {"hover"}


@pytest.mark.parametrize(
    ("reference", "supervisor", "parts"),
    [
        (MovingTarget(height_m=0.0), {}, ("height_m", "too low (0 m)", "lowest_m", "all the time")),
        (
            MovingTarget(velocity_m_s=(0.0, 2.0, 0.0)),
            {},
            ("reference.velocity_m_s", "too fast (2 m/s", "fastest_m_s (1.5 m/s)", "all the time"),
        ),
        (
            MovingTarget(target_m=(60.0, 0.0, 0.0)),
            {},
            ("reference.target_m", "too far", "farthest_m (50 m)", "all the time"),
        ),
        (Clover(amplitude_m=10.0, lap_s=1.0), {}, ("lap_s", "too fast", "from 0.", "for ")),
        (Lissajous(period_s=(1.0, 8.0, 8.0)), {}, ("reference.amplitude_m or period_s", "fast")),
        (Clover(), {"lowest_m": 1.5}, ("too low", "lowest_m (1.5 m)", "all the time")),
        (Clover(), {"farthest_m": 0.6}, ("too far", "farthest_m (0.6 m)", "from ")),
    ],
)
def test_a_violation_is_reported_with_its_keys(reference, supervisor, parts):
    limits = replace(Supervisor(), **supervisor)
    scenario = Scenario(reference=reference, supervisor=limits, duration=10.0)
    (note,) = [note for note in scenario_notes(scenario) if "the reference is" in note]
    assert all(part in note for part in parts), note


def test_a_target_that_leaves_is_too_far_from_then_on():
    """At 1.4 m/s from 1.3 m: farther than 2 m after about 1.4 s."""
    target = MovingTarget(target_m=(0.0, 0.2, 0.6), velocity_m_s=(1.4, 0.0, 0.0))
    supervisor = replace(Supervisor(), farthest_m=2.0)
    scenario = Scenario(reference=target, supervisor=supervisor, duration=3.0)
    (note,) = notes_of(scenario)
    first = next(t for t in np.arange(0, 3, 0.02) if 1.4 * t > 2.0)
    assert f"from {first:.2f} s on" in note


def test_all_violations_of_a_file_are_reported(tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("t,x,y,z\n0,0,0.2,1.2\n1,0,0.2,-1\n2,0,0.2,1.2\n")
    scenario = Scenario(reference=Waypoints(file=str(file)), duration=2.0)
    notes = notes_of(scenario)
    assert ["too low" in notes[0], "too fast" in notes[1], len(notes)] == [True, True, 2]
    assert all(note.startswith("reference.file: ") for note in notes)

"""The URDF is read once for one flight."""

from collections import Counter

import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.vehicle import drake_parser
from aerodrake.model.vehicle.robot import RobotDescription
from aerodrake.scenario import Flight, Mismatch, Payload, Scenario
from aerodrake.scenario.references import Clover
from aerodrake.station import make_closed_loop
from aerodrake.support import urdf

FLOWN = Scenario(
    duration=0.1,
    settle_s=0.0,
    reference=Clover(start_s=0.2),
    flight=Flight(feedforward="whole_body"),
    payload=Payload(mass_kg=0.1),
    mismatch=Mismatch(mass_scale=1.1),
)
"""A scenario whose systems need kinematics, dynamics, tucking and a plant of its own."""


@pytest.fixture
def calls(monkeypatch) -> Counter:
    """Counts of reading the file, of parsing its XML, and of Drake's parser."""
    counts = Counter()

    def count(module, name):
        original = getattr(module, name)

        def counted(*args):
            counts[name] += 1
            return original(*args)

        monkeypatch.setattr(module, name, counted)

    count(urdf, "read_bounded")
    count(urdf, "_UrdfBuilder")
    count(drake_parser, "Parser")
    return counts


def test_a_flight_reads_its_urdf_once(calls):
    """Drake parses it for the nominal plant, and for the simulated one with its mismatch."""
    FlightSimulation(FLOWN)
    assert calls == {"read_bounded": 1, "_UrdfBuilder": 1, "Parser": 2}


def test_a_closed_loop_reads_its_urdf_once(calls):
    make_closed_loop(FLOWN)
    assert calls == {"read_bounded": 1, "_UrdfBuilder": 1, "Parser": 2}


def test_description_keeps_the_path_it_was_given(vehicle):
    again = RobotDescription.read(vehicle.robot)
    assert again.robot == vehicle.robot == vehicle.description.robot
    assert again.document.toxml() == vehicle.description.document.toxml()

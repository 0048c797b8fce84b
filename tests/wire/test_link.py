"""Two ends of a link receive messages of each other only."""

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm

from aerodrake.support.errors import BadInput
from aerodrake.wire.link import COORDINATOR, STATION, Link
from aerodrake.wire.message import Layout, Message, Phase

SCENARIO = {"rates": 3, "mpc": 5}
SIZES = {"state": 3, "saturated": 1}


def layouts(scenario=SCENARIO, sizes=SIZES):
    """Returns the layouts of the station and of the coordinator."""
    return Layout(scenario, sizes), Layout(scenario, {"plan": 2})


LAYOUT = layouts()[0]
ZEROS = {name: np.zeros(size) for name, size in SIZES.items()}


@pytest.fixture
def ends():
    lcm = DrakeLcm("memq://")
    return Link(lcm, *layouts(), is_station=True), Link(lcm, *layouts(), is_station=False)


def test_messages_arrive_at_the_other_end(ends):
    station, coordinator = ends
    station.phase = Phase.FLYING
    station.publish(0.01, {"state": np.arange(3.0)})
    station.publish(0.02, {})
    first, second = coordinator.receive()
    assert (first.time, first.phase) == (0.01, Phase.FLYING)
    assert first.signals["state"].tolist() == [0, 1, 2] and first.signals["saturated"].tolist() == [
        0
    ]
    assert second.time == 0.02 and coordinator.receive() == []
    coordinator.publish(0.02, {"plan": np.ones(2)})
    (reply,) = station.receive()
    assert reply.signals["plan"].tolist() == [1, 1]


def test_rejected_messages_are_counted_and_reported_once():
    lcm, notes = DrakeLcm("memq://"), []
    station = Link(lcm, *layouts(), is_station=True, notify=notes.append)
    coordinator = Link(lcm, *layouts(), is_station=False)
    for data in (b"", b"hello", LAYOUT.encode(Message(0, Phase(0), station.station, ZEROS))):
        station.lcm.Publish(COORDINATOR, data)
    coordinator.station = station.station
    coordinator.publish(0.0, {})
    assert len(station.receive()) == 1 and station.rejected == 3
    assert notes == ["note: messages of another format or version are ignored"]


def test_the_newest_messages_of_a_flood_are_received(ends):
    station, coordinator = ends
    for i in range(1000):
        station.publish(i / 100, {})
        station.lcm.Publish(STATION, b"noise")
    times = [message.time for message in coordinator.receive()]
    assert len(times) == 50 and times[-1] == 9.99


def test_waiting_ends_with_a_reply(ends):
    station, coordinator = ends
    received = []

    def check():
        received.append(len(coordinator.receive()))
        if len(received) == 3:
            coordinator.publish(0.0, {})

    station.wait(check)
    assert received == [1, 1, 1]


def test_waiting_can_be_interrupted(ends):
    def check():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ends[0].wait(check)


def test_the_end_is_announced_until_it_is_confirmed():
    """The coordinator receives the third announcement first, and confirms it."""
    lcm = DrakeLcm("memq://")
    station, coordinator = Link(lcm, *layouts(), True), Link(lcm, *layouts(), False)
    coordinator.station = station.station
    phases = []

    def reply(message: bytes) -> None:
        phases.append(LAYOUT.decode(message).phase)
        if len(phases) == 3:
            coordinator.phase = Phase.OVER
            coordinator.publish(1.0, {})

    lcm.Subscribe(STATION, reply)
    station.close(1.0)
    assert phases[:3] == [Phase.OVER] * 3 and len(phases) <= 4
    assert station.phase is Phase.OVER


def test_a_dead_end_is_not_waited_for():
    station = Link(DrakeLcm("memq://"), *layouts(), True)
    station.close(1.0)
    assert station.phase is Phase.OVER


OTHER = {"rates": 4, "mpc": 5}


def test_another_scenario_is_refused_at_both_ends():
    """The sizes of signals differ as well."""
    lcm = DrakeLcm("memq://")
    station = Link(lcm, *layouts(OTHER, {"state": 4}), True)
    coordinator = Link(lcm, *layouts(), False)
    station.publish(0.0, {})
    with pytest.raises(BadInput) as at_coordinator:
        coordinator.receive()
    with pytest.raises(BadInput) as at_station:
        station.wait(lambda: None)
    expected = "lcm: expected a {} of the same scenario, got one that differs in rates"
    assert str(at_coordinator.value) == expected.format("station")
    assert str(at_station.value) == expected.format("coordinator")


@pytest.mark.parametrize("first", [STATION, COORDINATOR])
def test_the_refusal_is_announced_until_it_is_confirmed(first):
    """The first four messages of the other end are lost."""
    lcm = DrakeLcm("memq://")
    refusing = Link(lcm, *layouts(), first == STATION)
    received = []

    def reply(message):
        received.append(refusing.outgoing.decode(message))
        if len(received) == 5:
            other.phase = Phase.OVER
            other.publish(0.0, {})

    lcm.Subscribe(first, reply)
    other = Link(lcm, *layouts(OTHER), first != STATION)
    other.station = refusing.station = 9
    other.publish(0.0, {})
    with pytest.raises(BadInput):
        refusing.receive()
    assert len(received) <= 6
    assert {(message.phase, message.station) for message in received} == {(Phase.OVER, 9)}


@pytest.mark.parametrize("is_station", [True, False])
def test_in_flight_another_scenario_is_ignored_and_reported_once(is_station):
    lcm, notes = DrakeLcm("memq://"), []
    flying = Link(lcm, *layouts(), is_station, notes.append)
    other = Link(lcm, *layouts({"rates": 0, "mpc": 0}), not is_station)
    flying.phase, flying.station = Phase.FLYING, 9
    other.station = 9
    for other.phase in (*Phase, Phase.FLYING):
        other.publish(0.0, {})
        assert flying.receive() == []
    assert notes == ["note: messages of another scenario are ignored; it differs in rates, mpc"]
    assert flying.rejected == 4


def test_the_first_of_two_stations_is_served_and_the_other_reported():
    lcm, notes = DrakeLcm("memq://"), []
    coordinator = Link(lcm, *layouts(), False, notes.append)
    first, second = (Link(lcm, *layouts(), True, notes.append) for _ in range(2))
    assert first.station != second.station
    for station, phase in ((first, Phase.WAITING), (second, Phase.WAITING), (second, Phase.OVER)):
        station.phase = phase
        station.publish(0.0, {})
    (message,) = coordinator.receive()
    assert message.station == coordinator.station == first.station
    coordinator.publish(0.0, {})
    assert (len(first.receive()), len(second.receive())) == (1, 0)
    assert notes == [
        "note: messages of another station are ignored",
        "note: the coordinator serves another station",
    ]


def test_a_finished_flight_is_not_served():
    lcm = DrakeLcm("memq://")
    coordinator, station = Link(lcm, *layouts(), False), Link(lcm, *layouts(OTHER), True)
    station.phase = Phase.OVER
    station.publish(0.0, {})
    assert coordinator.receive() == [] and coordinator.station is None


def test_the_end_is_confirmed_by_the_own_coordinator_only():
    lcm = DrakeLcm("memq://")
    station, other = Link(lcm, *layouts(), True), Link(lcm, *layouts(), False)
    other.station, other.phase = station.station ^ 1, Phase.OVER
    received = []

    def reply(message):
        received.append(message)
        other.publish(0.0, {})

    lcm.Subscribe(STATION, reply)
    station.close(1.0)
    assert len(received) > 20

"""Two ends of a wire: each hears the other, and nobody else."""

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm

from aerodrake.support.errors import BadInput
from aerodrake.wire.link import COORDINATOR, STATION, Link, make_lcm
from aerodrake.wire.message import Layout, Message, Phase

SCENARIO = {"rates": 3, "mpc": 5}
SIZES = {"state": 3, "saturated": 1}


def layouts(scenario=SCENARIO, sizes=SIZES):
    """Of the station, and of the coordinator."""
    return Layout(scenario, sizes), Layout(scenario, {"plan": 2})


LAYOUT = layouts()[0]
ZEROS = {name: np.zeros(size) for name, size in SIZES.items()}


@pytest.fixture
def ends():
    lcm = DrakeLcm("memq://")
    return Link(lcm, *layouts(), is_station=True), Link(lcm, *layouts(), is_station=False)


def test_two_ends(ends):
    station, coordinator = ends
    station.phase = Phase.FLYING
    station.tell(0.01, {"state": np.arange(3.0)})
    station.tell(0.02, {})
    first, second = coordinator.hear()
    assert (first.time, first.phase) == (0.01, Phase.FLYING)
    assert first.parts["state"].tolist() == [0, 1, 2] and first.parts["saturated"].tolist() == [0]
    assert second.time == 0.02 and coordinator.hear() == []
    coordinator.tell(0.02, {"plan": np.ones(2)})
    (answer,) = station.hear()
    assert answer.parts["plan"].tolist() == [1, 1]


def test_what_is_refused_is_counted_and_said_once_and_harms_nothing():
    lcm, notes = DrakeLcm("memq://"), []
    station = Link(lcm, *layouts(), is_station=True, say=notes.append)
    coordinator = Link(lcm, *layouts(), is_station=False)
    for data in (b"", b"hello", LAYOUT.encode(Message(0, Phase(0), station.station, ZEROS))):
        station.lcm.Publish(COORDINATOR, data)
    coordinator.station = station.station
    coordinator.tell(0.0, {})
    assert len(station.hear()) == 1 and station.refused == 3
    assert notes == ["note: messages come that are not of ours, or of another version"]


def test_of_a_flood_the_newest_is_heard(ends):
    station, coordinator = ends
    for i in range(1000):
        station.tell(i / 100, {})
        station.lcm.Publish(STATION, b"noise")
    times = [message.time for message in coordinator.hear()]
    assert len(times) == 50 and times[-1] == 9.99


def test_waiting_ends_with_an_answer(ends):
    station, coordinator = ends
    asked = []

    def check():
        asked.append(len(coordinator.hear()))
        if len(asked) == 3:
            coordinator.tell(0.0, {})

    station.wait(check)
    assert asked == [1, 1, 1]


def test_waiting_can_be_given_up(ends):
    def check():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ends[0].wait(check)


@pytest.mark.parametrize(
    "url",
    [
        *("", "nonsense", "memq://", "udpm://", "udpm://239.255.76.67", "udp://239.255.76.67:7667"),
        *("udpm://10.0.0.1:7667", "udpm://239.255.76.300:7667", "udpm://239.255.76.67:0"),
        *("udpm://239.255.76.67:70000", "udpm://239.255.76.67:7667?ttl=256"),
        *("udpm://239.255.76.67:7667?ttl=", "udpm://239.255.76.67:7667?tll=1"),
    ],
)
def test_an_address_that_is_none(url):
    with pytest.raises(BadInput, match="^--lcm: expected udpm://"):
        make_lcm(url)


def test_an_address():
    url = "udpm://239.255.76.67:7668?ttl=0"
    assert make_lcm(url).get_lcm_url() == url


def test_the_end_is_said_until_it_is_heard():
    """By one who hears the third message at first, and then says the same."""
    lcm = DrakeLcm("memq://")
    station, coordinator = Link(lcm, *layouts(), True), Link(lcm, *layouts(), False)
    coordinator.station = station.station
    heard = []

    def answer(message: bytes) -> None:
        heard.append(LAYOUT.decode(message).phase)
        if len(heard) == 3:
            coordinator.phase = Phase.OVER
            coordinator.tell(1.0, {})

    lcm.Subscribe(STATION, answer)
    station.part(1.0)
    assert heard[:3] == [Phase.OVER] * 3 and len(heard) <= 4
    assert station.phase is Phase.OVER


def test_nobody_waits_for_ever_for_the_dead():
    station = Link(DrakeLcm("memq://"), *layouts(), True)
    station.part(1.0)
    assert station.phase is Phase.OVER


OTHER = {"rates": 4, "mpc": 5}


def test_who_waits_refuses_another_scenario_and_both_find_out():
    """The station has other sizes, too; its waiting brings the coordinator's answer about."""
    lcm = DrakeLcm("memq://")
    station = Link(lcm, *layouts(OTHER, {"state": 4}), True)
    coordinator = Link(lcm, *layouts(), False)
    station.tell(0.0, {})
    with pytest.raises(BadInput) as at_coordinator:
        coordinator.hear()
    with pytest.raises(BadInput) as at_station:
        station.wait(lambda: None)
    expected = "--lcm: expected a {} of the same scenario, got one that differs in rates"
    assert str(at_coordinator.value) == expected.format("station")
    assert str(at_station.value) == expected.format("coordinator")


@pytest.mark.parametrize("first", [STATION, COORDINATOR])
def test_the_refusal_is_said_until_it_is_heard(first):
    """By either end to the other, whose first four messages are lost."""
    lcm = DrakeLcm("memq://")
    refusing = Link(lcm, *layouts(), first == STATION)
    told = []

    def answer(message):
        told.append(refusing.tells.decode(message))
        if len(told) == 5:
            other.phase = Phase.OVER
            other.tell(0.0, {})

    lcm.Subscribe(first, answer)
    other = Link(lcm, *layouts(OTHER), first != STATION)
    other.station = refusing.station = 9
    other.tell(0.0, {})
    with pytest.raises(BadInput):
        refusing.hear()
    assert len(told) <= 6
    assert {(message.phase, message.station) for message in told} == {(Phase.OVER, 9)}


@pytest.mark.parametrize("is_station", [True, False])
def test_in_flight_another_scenario_is_not_heard_and_said_once(is_station):
    lcm, notes = DrakeLcm("memq://"), []
    flying = Link(lcm, *layouts(), is_station, notes.append)
    other = Link(lcm, *layouts({"rates": 0, "mpc": 0}), not is_station)
    flying.phase, flying.station = Phase.FLYING, 9
    other.station = 9
    for other.phase in (*Phase, Phase.FLYING):
        other.tell(0.0, {})
        assert flying.hear() == []
    assert notes == ["note: messages come of another scenario, which differs in rates, mpc"]
    assert flying.refused == 4


def test_the_first_of_two_stations_is_served_and_the_other_noted():
    lcm, notes = DrakeLcm("memq://"), []
    coordinator = Link(lcm, *layouts(), False, notes.append)
    first, second = (Link(lcm, *layouts(), True, notes.append) for _ in range(2))
    assert first.station != second.station
    for station, phase in ((first, Phase.WAITING), (second, Phase.WAITING), (second, Phase.OVER)):
        station.phase = phase
        station.tell(0.0, {})
    (message,) = coordinator.hear()
    assert message.station == coordinator.station == first.station
    coordinator.tell(0.0, {})
    assert (len(first.hear()), len(second.hear())) == (1, 0)
    assert notes == [
        "note: another station is there, and is not answered",
        "note: the coordinator answers another station",
    ]


def test_a_flight_that_is_over_is_nobodys():
    lcm = DrakeLcm("memq://")
    coordinator, station = Link(lcm, *layouts(), False), Link(lcm, *layouts(OTHER), True)
    station.phase = Phase.OVER
    station.tell(0.0, {})
    assert coordinator.hear() == [] and coordinator.station is None


def test_a_farewell_is_not_taken_from_a_coordinator_of_others():
    lcm = DrakeLcm("memq://")
    station, other = Link(lcm, *layouts(), True), Link(lcm, *layouts(), False)
    other.station, other.phase = station.station ^ 1, Phase.OVER
    told = []

    def answer(message):
        told.append(message)
        other.tell(0.0, {})

    lcm.Subscribe(STATION, answer)
    station.part(1.0)
    assert len(told) > 20

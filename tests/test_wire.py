"""Messages: what is told is heard, and nothing else is."""

import numpy as np
import pytest
from drake import lcmt_drake_signal
from hypothesis import given
from hypothesis import strategies as st
from pydrake.lcm import DrakeLcm

from aerodrake.errors import BadInput
from aerodrake.wire import COORDINATOR, STATION, Layout, Link, Message, Phase, make_lcm

LAYOUT = Layout({"state": 3, "saturated": 1})
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
ZEROS = {"state": np.zeros(3), "saturated": np.zeros(1)}
MESSAGES = st.builds(
    lambda ticks, phase, numbers: Message(
        ticks / 1e6, phase, {"state": np.array(numbers[:3]), "saturated": np.array(numbers[3:])}
    ),
    st.integers(0, 10**12),
    st.sampled_from(Phase),
    st.lists(NUMBERS, min_size=4, max_size=4),
)


@given(MESSAGES)
def test_what_is_told_is_heard_to_the_last_bit(message):
    heard = LAYOUT.decode(LAYOUT.encode(message))
    assert heard.time == message.time and heard.phase is message.phase
    assert list(heard.parts) == ["state", "saturated"]
    for name, numbers in message.parts.items():
        np.testing.assert_array_equal(heard.parts[name], numbers)


def test_others_read_it_as_drakes_own_signal():
    """By names, as a bridge to hardware would."""
    parts = {"state": np.arange(3.0), "saturated": np.ones(1)}
    signal = lcmt_drake_signal.decode(LAYOUT.encode(Message(0.02, Phase.FLYING, parts)))
    assert signal.timestamp == 20_000
    assert dict(zip(signal.coord, signal.val, strict=True)) == {
        "phase": 1.0,
        "state[0]": 0.0,
        "state[1]": 1.0,
        "state[2]": 2.0,
        "saturated[0]": 1.0,
    }


@given(st.binary(max_size=300))
def test_noise_is_no_message(data):
    assert LAYOUT.decode(data) is None


@given(MESSAGES, st.data())
def test_a_damaged_message_is_none_or_whole(message, data):
    good = LAYOUT.encode(message)
    at = data.draw(st.integers(0, len(good) - 1))
    if data.draw(st.booleans()):
        bad = good[:at]
    else:
        bad = good[:at] + data.draw(st.binary(min_size=1, max_size=9)) + good[at + 1 :]
    heard = LAYOUT.decode(bad)
    if heard is not None:
        assert heard.phase in tuple(Phase)
        assert {name: len(part) for name, part in heard.parts.items()} == LAYOUT.sizes


@pytest.mark.parametrize(
    "other", [{"state": 4, "saturated": 1}, {"saturated": 1, "state": 3}, {"state": 3}, {}], ids=str
)
def test_messages_of_another_robot_are_none(other):
    layout = Layout(other)
    parts = {name: np.zeros(size) for name, size in other.items()}
    message = Message(0.0, Phase.FLYING, parts or {})
    if other:
        assert LAYOUT.decode(layout.encode(message)) is None
    empty = lcmt_drake_signal()
    assert LAYOUT.decode(empty.encode()) is None


@pytest.mark.parametrize("phase", [-1.0, 3.0, 0.5, np.nan, np.inf, 1e300])
def test_a_phase_that_there_is_not(phase):
    signal = lcmt_drake_signal.decode(LAYOUT.encode(Message(0.0, Phase.FLYING, ZEROS)))
    signal.val = [phase, *signal.val[1:]]
    assert LAYOUT.decode(signal.encode()) is None


@pytest.fixture
def ends():
    lcm = DrakeLcm("memq://")
    layouts = LAYOUT, Layout({"plan": 2})
    return Link(lcm, *layouts, is_station=True), Link(lcm, *layouts, is_station=False)


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
    layouts = LAYOUT, Layout({"plan": 2})
    station = Link(lcm, *layouts, is_station=True, say=notes.append)
    coordinator = Link(lcm, *layouts, is_station=False)
    for data in (b"", b"hello", LAYOUT.encode(Message(0, Phase(0), ZEROS))):
        station.lcm.Publish(COORDINATOR, data)
    coordinator.tell(0.0, {})
    assert len(station.hear()) == 1 and station.refused == 3
    assert notes == ["note: messages come of another robot or horizon, or not of ours"]


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
    layouts = LAYOUT, Layout({"plan": 2})
    station, coordinator = Link(lcm, *layouts, True), Link(lcm, *layouts, False)
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
    station = Link(DrakeLcm("memq://"), LAYOUT, Layout({"plan": 2}), True)
    station.part(1.0)
    assert station.phase is Phase.OVER

"""Messages are decoded to the last bit, or not at all."""

import numpy as np
import pytest
from drake import lcmt_drake_signal
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.wire.message import NUMBERS, Layout, Message, Phase

SCENARIO = {"rates": 0, "mpc": NUMBERS - 1}
LAYOUT = Layout(SCENARIO, {"state": 3, "saturated": 1})
FLOATS = st.floats(allow_nan=True, allow_infinity=True)
ZEROS = {"state": np.zeros(3), "saturated": np.zeros(1)}
MESSAGES = st.builds(
    lambda ticks, phase, station, numbers: Message(
        ticks / 1e6,
        phase,
        station,
        {"state": np.array(numbers[:3]), "saturated": np.array(numbers[3:])},
    ),
    st.integers(0, 10**12),
    st.sampled_from(Phase),
    st.integers(0, NUMBERS - 1),
    st.lists(FLOATS, min_size=4, max_size=4),
)


@given(MESSAGES)
def test_messages_are_decoded_to_the_last_bit(message):
    decoded = LAYOUT.decode(LAYOUT.encode(message))
    assert decoded.time == message.time and decoded.phase is message.phase
    assert decoded.station == message.station and decoded.differing == ()
    assert list(decoded.signals) == ["state", "saturated"]
    for name, numbers in message.signals.items():
        np.testing.assert_array_equal(decoded.signals[name], numbers)


def test_a_message_is_drakes_own_signal():
    """A bridge to hardware can read it by names."""
    signals = {"state": np.arange(3.0), "saturated": np.ones(1)}
    signal = lcmt_drake_signal.decode(LAYOUT.encode(Message(0.02, Phase.FLYING, 7, signals)))
    assert signal.timestamp == 20_000
    assert dict(zip(signal.coord, signal.val, strict=True)) == {
        "phase": 1.0,
        "station": 7.0,
        "scenario.rates": 0.0,
        "scenario.mpc": 2.0**48 - 1,
        "state[0]": 0.0,
        "state[1]": 1.0,
        "state[2]": 2.0,
        "saturated[0]": 1.0,
    }


@given(st.binary(max_size=300))
def test_noise_is_not_decoded(data):
    assert LAYOUT.decode(data) is None


@given(MESSAGES, st.data())
def test_a_damaged_message_is_decoded_completely_or_not_at_all(message, data):
    good = LAYOUT.encode(message)
    at = data.draw(st.integers(0, len(good) - 1))
    if data.draw(st.booleans()):
        bad = good[:at]
    else:
        bad = good[:at] + data.draw(st.binary(min_size=1, max_size=9)) + good[at + 1 :]
    decoded = LAYOUT.decode(bad)
    if decoded is not None and not decoded.differing:
        assert decoded.phase in tuple(Phase)
        assert {name: len(values) for name, values in decoded.signals.items()} == LAYOUT.sizes


@pytest.mark.parametrize(
    "other", [{"state": 4, "saturated": 1}, {"saturated": 1, "state": 3}, {"state": 3}, {}], ids=str
)
def test_messages_of_another_robot_are_not_decoded(other):
    layout = Layout(SCENARIO, other)
    signals = {name: np.zeros(size) for name, size in other.items()}
    message = Message(0.0, Phase.FLYING, 7, signals)
    if other:
        assert LAYOUT.decode(layout.encode(message)) is None
    empty = lcmt_drake_signal()
    assert LAYOUT.decode(empty.encode()) is None


@pytest.mark.parametrize("phase", [-1.0, 3.0, 0.5, np.nan, np.inf, 1e300])
def test_an_invalid_phase_is_not_decoded(phase):
    signal = lcmt_drake_signal.decode(LAYOUT.encode(Message(0.0, Phase.FLYING, 7, ZEROS)))
    signal.val = [phase, *signal.val[1:]]
    assert LAYOUT.decode(signal.encode()) is None


@pytest.mark.parametrize("station", [-1.0, 0.5, 2.0**48, np.nan, np.inf])
def test_an_invalid_station_is_not_decoded(station):
    signal = lcmt_drake_signal.decode(LAYOUT.encode(Message(0.0, Phase.FLYING, 7, ZEROS)))
    signal.val = [signal.val[0], station, *signal.val[2:]]
    assert LAYOUT.decode(signal.encode()) is None


@pytest.mark.parametrize("sizes", [LAYOUT.sizes, {"state": 4}], ids=str)
@pytest.mark.parametrize("differing", [("rates",), ("mpc",), ("rates", "mpc")], ids=str)
def test_another_scenario_is_decoded_to_the_sections_that_differ(sizes, differing):
    other = Layout({name: n ^ (name in differing) for name, n in SCENARIO.items()}, sizes)
    signals = {name: np.ones(size) for name, size in sizes.items()}
    decoded = LAYOUT.decode(other.encode(Message(0.5, Phase.WAITING, 7, signals)))
    assert decoded == Message(0.5, Phase.WAITING, 7, {}, differing)


@pytest.mark.parametrize("scenario", [{}, {"rates": 0}, {"mpc": 0, "rates": 0}], ids=str)
def test_other_sections_are_not_decoded(scenario):
    other = Layout(scenario, LAYOUT.sizes)
    assert LAYOUT.decode(other.encode(Message(0.0, Phase.WAITING, 7, ZEROS))) is None

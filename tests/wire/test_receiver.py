"""Outputs of a receiver with and without replies of the coordinator."""

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator

from aerodrake.model.mpc.tick import MISSED
from aerodrake.wire.link import Link
from aerodrake.wire.message import Layout, Phase
from aerodrake.wire.receiver import WireReceiver

PERIOD, POLL = 0.02, 0.001
AXES = 2
STAGES_S = np.array([0.0, 0.02, 0.05, 0.1])
SIZES = {
    "segment": 3 * AXES + 1,
    "plan": 3 * AXES,
    "status": 3,
    "delta": 2,
    "horizon": 18,
    "tool_axis_horizon": 18,
    "tick_ms": 1,
    "output_time_s": 1,
}


class Bench:
    """Receiver with a scripted coordinator."""

    def __init__(self, vehicle):
        lcm, layouts = DrakeLcm("memq://"), (Layout({}, {"state": 1}), Layout({}, SIZES))
        self.coordinator = Link(lcm, *layouts, is_station=False)
        self.coordinator.phase = Phase.FLYING
        link = Link(lcm, *layouts, is_station=True)
        self.coordinator.station = link.station
        self.link = link
        self.receiver = WireReceiver(link, PERIOD, STAGES_S, vehicle, POLL, 3 * POLL / 8)
        self.simulator = Simulator(self.receiver)

    def reply(self, time, value, **others):
        """Publishes a reply with u of `value` at the tick, and 10 and 20 more at the next ones."""
        segment = np.concatenate([np.full(2 * AXES, 99.0), np.full(AXES, value), [time]])
        plan = np.repeat([-1.0, value + 10, value + 20], AXES)
        signals = {
            "segment": segment,
            "plan": plan,
            "status": np.array([1.0, 7.0, 2.0]),
            "delta": np.array([value, -value]),
            "tick_ms": np.array([0.1 * value]),
        }
        self.coordinator.publish(time, signals | others)

    def at(self, time, port="u"):
        self.simulator.AdvanceTo(time)
        return self.receiver.GetOutputPort(port).Eval(self.simulator.get_context()).tolist()


@pytest.fixture
def bench(vehicle):
    return Bench(vehicle)


def test_before_the_first_message_ticks_are_missed(bench):
    assert bench.at(0.005) == [0, 0]
    assert bench.at(0.045, "status") == [MISSED, 0, 3]


def test_the_plan_is_followed_until_the_next_reply(bench):
    bench.reply(0.0, 1.0)
    assert bench.at(0.003) == [1, 1]
    assert bench.at(0.019) == [1, 1]
    assert bench.at(0.021) == [11, 11]
    bench.reply(0.02, 2.0)
    assert bench.at(0.0225) == [2, 2]
    assert bench.at(0.0225, "delta") == [2, -2]
    assert bench.link.tick_ms == pytest.approx([0.1, 0.2])


def test_the_plan_ends_in_rest(bench):
    bench.reply(0.0, 1.0)
    assert [bench.at(t)[0] for t in (0.01, 0.03, 0.05, 0.07, 0.5)] == [1, 11, 21, 0, 0]


def test_ticks_without_a_reply_are_missed(bench):
    bench.reply(0.0, 1.0)
    assert bench.at(0.01, "status") == [1, 7, 2]
    assert bench.at(0.03, "status") == [MISSED, 0, 3]
    assert bench.at(0.05, "status") == [MISSED, 0, 4]
    bench.reply(0.04, 1.0)
    assert bench.at(0.055, "status") == [1, 7, 2]
    assert len(bench.link.tick_ms) == 2


@pytest.mark.parametrize("time", [0.0, 0.02, 0.06, -0.04, 1e6])
def test_replies_to_other_ticks_are_not_followed(bench, time):
    bench.at(0.045)
    bench.reply(time, 5.0)
    assert bench.at(0.055) == [0, 0] and not bench.link.tick_ms


def test_the_first_reply_counts(bench):
    bench.reply(0.0, 1.0)
    bench.reply(0.0, 2.0)
    assert bench.at(0.01) == [1, 1] and len(bench.link.tick_ms) == 1


@pytest.mark.parametrize("signal", ["segment", "plan", "horizon"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_replies_with_nan_or_infinity_are_not_followed(bench, signal, value):
    bench.reply(0.0, 1.0, **{signal: np.full(SIZES[signal], value)})
    assert bench.at(0.01) == [0, 0]
    bench.reply(0.0, 3.0)
    assert bench.at(0.012) == [3, 3] and bench.link.rejected == 1


def test_before_the_first_message_the_reference_is_the_hover_in_trim(bench, vehicle):
    assert bench.at(0.005, "reference") == [*vehicle.p_E, 0, 0, 0]
    assert bench.at(0.3, "tool_axis_d") == vehicle.tool_axis.tolist()


def motion(times):
    """(T, 6) a cubic of time, which Hermite splines interpolate exactly, and its derivative."""
    p = np.stack([1 + times, times**2, times - times**3], axis=1)
    v = np.stack([np.ones_like(times), 2 * times, 1 - 3 * times**2], axis=1)
    return np.hstack([p, v])


def test_horizons_are_interpolated_at_the_current_time(bench):
    """The message has three of the four stages; it was evaluated 0.2 ms after its tick."""
    rows = motion(0.0002 + STAGES_S[:3])
    horizons = {"horizon": rows.ravel(), "tool_axis_horizon": rows[:, [2, 0, 1, 5, 3, 4]].ravel()}
    bench.reply(0.0, 1.0, **horizons, output_time_s=np.array([0.0002]))
    for time in (0.0031, 0.02, 0.033, 0.05):
        expected = motion(np.array([time]))[0]
        assert bench.at(time, "reference") == pytest.approx(expected, abs=1e-12)
        assert bench.at(time, "tool_axis_d") == pytest.approx(expected[[2, 0, 1]], abs=1e-12)
    for time in (0.0503, 0.2):
        assert bench.at(time, "reference") == [*rows[-1, :3], 0, 0, 0]


def test_logged_signals_may_be_nan(bench):
    bench.reply(0.0, 1.0, delta=np.full(2, np.nan))
    assert bench.at(0.01) == [1, 1] and np.isnan(bench.at(0.01, "delta")).all()


def test_a_tick_that_the_coordinator_missed_has_no_wall_time(bench):
    bench.reply(0.0, 1.0, tick_ms=np.array([np.nan]))
    assert bench.at(0.01) == [1, 1] and bench.link.tick_ms == []


@pytest.mark.parametrize("phase", [Phase.WAITING, Phase.OVER])
def test_replies_of_another_phase_are_not_followed(bench, phase):
    bench.coordinator.phase = phase
    bench.reply(0.0, 1.0)
    assert bench.at(0.01) == [0, 0]


def test_replies_to_another_station_are_not_followed(bench):
    bench.coordinator.station ^= 1
    bench.reply(0.0, 1.0)
    assert bench.at(0.01) == [0, 0]

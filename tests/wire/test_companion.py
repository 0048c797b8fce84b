"""Companion with a scripted station."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.lcm import DrakeLcm

from aerodrake.coordinator import make_coordinator
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.scenario import Clover, Mpc, Rates, Scenario, Supervisor
from aerodrake.station import make_context
from aerodrake.support.errors import BadInput
from aerodrake.wire.companion import Companion
from aerodrake.wire.link import STATION
from aerodrake.wire.message import Phase
from aerodrake.wire.remote_coordinator import make_station_link

PERIOD = 0.01


@pytest.fixture
def bench(scenario, vehicle):
    return Bench(scenario, vehicle)


class Bench:
    def __init__(self, scenario, vehicle):
        self.lcm = DrakeLcm("memq://")
        self.notes = []
        self.companion = Companion(scenario, self.lcm, self.notes.append)
        self.station = make_station_link(scenario, self.lcm)
        zeros = {name: np.zeros(size) for name, size in self.station.outgoing.sizes.items()}
        position = np.concatenate([vehicle.p_B, vehicle.working])
        self.sample = zeros | {
            "state": vehicle.trim_state,
            "specific_thrust": np.array([GRAVITY]),
            "rotor_effectiveness": np.ones(len(vehicle.rotors.names)),
            "followed": np.concatenate([position, np.zeros(2 * len(position) + 1)]),
        }

    def publish(self, time, phase=Phase.FLYING, station=None, **signals):
        """Publishes a sample of the bench's station, or of another one."""
        station = station or self.station
        station.phase = phase
        station.publish(time, self.sample | signals)

    def replies(self, *times):
        """Returns the replies to samples at these times, one after another."""
        replies = []
        for time in times:
            self.publish(time)
            self.companion.process_messages()
            replies += self.station.receive()
        return replies


def test_a_waiting_station_receives_a_reply(bench):
    for _ in range(2):
        bench.publish(0.0, Phase.WAITING)
        bench.companion.process_messages()
        (reply,) = bench.station.receive()
        assert reply.phase is Phase.WAITING
    assert bench.companion.service.line() == "no flight"


def test_each_tick_has_one_reply(bench):
    replies = bench.replies(*(i * PERIOD for i in range(9)), 0.08, 0.04)
    assert [reply.time for reply in replies] == pytest.approx([0, 0.02, 0.04, 0.06, 0.08])
    assert all(reply.phase is Phase.FLYING for reply in replies)
    assert [reply.signals["segment"][-1] for reply in replies] == pytest.approx(
        [0, 0.02, 0.04, 0.06, 0.08]
    )
    service = bench.companion.service
    assert (len(service.reply_ms), service.missed, service.flown_s) == (5, 0, 0.08)
    assert service.line().startswith("0.08 s, 5 ticks, 0 missed, ")


def test_a_reply_contains_the_outputs_of_the_coordinator(bench):
    bench.replies(0.0, 0.01)
    (reply,) = bench.replies(0.02)
    m = len(reply.signals["segment"]) // 3
    plan = reply.signals["plan"].reshape(-1, m)
    assert len(plan) == Supervisor().plan_ticks + 2
    # At rest in trim no acceleration is needed.
    np.testing.assert_allclose(reply.signals["segment"][: 2 * m], bench.sample["followed"][: 2 * m])
    np.testing.assert_allclose(plan, 0.0, atol=1e-9)
    assert reply.signals["status"][2] == 0


def test_setpoints_start_from_the_followed_segment(bench):
    bench.replies(0.0, 0.01)
    elsewhere = bench.sample["followed"].copy()
    m = len(elsewhere) // 3
    elsewhere[0] += 0.1
    elsewhere[m] = 0.2
    elsewhere[-1] = 0.01
    bench.publish(0.02, followed=elsewhere)
    bench.companion.process_messages()
    (reply,) = bench.station.receive()
    assert reply.signals["segment"][0] == pytest.approx(elsewhere[0] + 0.01 * 0.2)
    assert reply.signals["segment"][m] == pytest.approx(0.2)


def test_ticks_without_their_sample_are_missed(bench):
    """They are not made up for."""
    bench.replies(0.0, 0.01, 0.03, 0.11)  # Without 0.02, 0.04, 0.06, 0.08 and 0.1.
    service = bench.companion.service
    assert service.missed == 5 and len(service.tick_ms) == 1
    assert bench.notes == ["note: ticks without a sample within half a sample period are missed"]
    reply, last = bench.replies(0.12, 0.13, 4.2)
    assert (reply.time, last.time) == (0.12, 4.2)
    assert service.missed == 5 + 203 and len(service.tick_ms) == 3


@pytest.mark.parametrize(
    "times",
    [
        2e-6 + PERIOD * np.arange(20),
        PERIOD * np.arange(20) + np.random.default_rng(0).uniform(-1e-3, 1e-3, 20),
        PERIOD * (1 + 10e-6) * np.arange(30_000, 30_020),
        4.9e-3 + PERIOD * np.arange(20),
    ],
    ids=["2 us late", "jitter of 1 ms", "10 ppm after 5 minutes", "half a period late"],
)
def test_samples_off_the_grid_are_answered_for_the_nearest_tick(bench, times):
    replies = bench.replies(*times)
    nearest = 2 * PERIOD * np.round(times[::2] / (2 * PERIOD))
    assert [reply.time for reply in replies] == pytest.approx(nearest)
    assert [reply.signals["segment"][-1] for reply in replies] == pytest.approx(nearest)
    assert bench.notes == [] and bench.companion.service.missed == 0


def test_another_sample_period_is_reported(bench):
    replies = bench.replies(*(0.012 * np.arange(60)))
    assert len(replies) == 36
    expected = "expected samples every 0.01 s (rates.sensor_period_s), got every 0.012 s"
    assert [note for note in bench.notes if expected in note] == bench.notes[-1:]


def test_a_flight_in_progress_is_served(bench):
    assert bench.replies(12.345678) == []
    (reply,) = bench.replies(12.35, 12.36)
    assert reply.time == pytest.approx(12.36)
    assert bench.companion.service.missed == 0


def test_noise_has_no_reply(bench):
    for data in (b"", b"noise", b"\0" * 1000):
        bench.lcm.Publish(STATION, data)
    assert not bench.companion.process_messages()
    assert bench.companion.link.rejected == 3


@pytest.fixture(scope="module")
def hostile_bench(scenario, vehicle):
    bench = Bench(scenario, vehicle)
    bench.replies(0.0)
    return bench


@given(st.data())
def test_after_absurd_samples_replies_are_finite(hostile_bench, data):
    """Any values of a signal: replies are finite, and the next sample is used."""
    bench = hostile_bench
    begin = bench.companion.service.flown_s
    signal = data.draw(st.sampled_from(sorted(bench.sample)))
    size = len(bench.sample[signal])
    values = st.floats() | st.sampled_from([0.0, 1.0, 9999.0, -9999.0, 1e300])
    value = data.draw(st.lists(values, min_size=size, max_size=size).map(np.array))
    bench.publish(begin + 0.02, **{signal: value})
    bench.companion.process_messages()
    for reply in [*bench.station.receive(), *bench.replies(begin + 0.04)]:
        assert np.isfinite(reply.signals["segment"]).all()
        assert np.isfinite(reply.signals["plan"]).all()
    assert bench.companion.service.flown_s == pytest.approx(begin + 0.04)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e5])
@pytest.mark.parametrize("signal", ["state", "disturbance", "followed"])
def test_absurd_samples_have_no_reply(bench, signal, value):
    bench.replies(0.0, 0.01)
    bench.publish(0.02, **{signal: np.full_like(bench.sample[signal], value)})
    bench.companion.process_messages()
    assert bench.station.receive() == []


@pytest.mark.parametrize("time", [1e6, -1.0])
def test_an_absurd_time_is_rejected_and_reported(bench, time):
    assert bench.replies(time) == []
    assert bench.companion.link.phase is Phase.WAITING
    expected = "expected ascending times in s since the start of the flight"
    assert bench.notes == [f"note: samples are ignored: {expected}, got {time:g} s"]


def test_late_and_repeated_samples_are_ignored(bench):
    assert len(bench.replies(0.0, 0.01, 0.02, 0.02, 0.01)) == 2
    assert bench.notes == [] and bench.companion.link.rejected == 0


def test_the_companion_ends_with_the_flight(bench):
    bench.replies(0.0, 0.01)
    bench.publish(0.02, Phase.OVER)
    service = bench.companion.serve(lambda flown_s: None)
    assert service.fault == "" and service.flown_s == 0.01


def test_the_end_of_another_flight_is_ignored(bench):
    bench.publish(0.0, Phase.OVER)
    bench.companion.process_messages()
    assert bench.companion.link.phase is Phase.WAITING


def test_a_silent_station_is_dead(vehicle):
    bench = Bench(
        Scenario(supervisor=Supervisor(attitude_outage_s=0.04, attitude_lost_s=0.05)), vehicle
    )
    bench.replies(0.0, 0.01)
    service = bench.companion.serve(lambda flown_s: None)
    assert service.fault == "no sample from the station for 0.05 s, since 0.01 s"


@pytest.mark.parametrize(
    "other, differing",
    [
        (Scenario(rates=Rates(mpc_period_s=0.04)), "rates"),
        (Scenario(reference=Clover(), settle_s=2.0), "settle_s, reference"),
        (Scenario(mpc=Mpc(horizon=7)), "mpc"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.parametrize("phase", [Phase.WAITING, Phase.FLYING])
def test_another_scenario_is_refused_at_both_ends(bench, phase, other, differing):
    station = make_station_link(other, bench.lcm)
    bench.publish(0.0, phase, station)
    with pytest.raises(BadInput, match=f"a station of the same .* that differs in {differing}$"):
        bench.companion.process_messages()
    assert bench.companion.service.reply_ms == []
    with pytest.raises(
        BadInput, match=f"a coordinator of the same .* that differs in {differing}$"
    ):
        station.wait(lambda: None)


def test_the_first_of_two_stations_is_served(bench):
    other = make_station_link(bench.companion.scenario, bench.lcm)
    for phase in (Phase.WAITING, Phase.FLYING):
        bench.publish(0.0, phase)
        bench.publish(0.0, phase, other)
        bench.companion.process_messages()
        (reply,) = bench.station.receive()
        assert (reply.phase, reply.station) == (phase, bench.station.station)
    bench.publish(0.02, Phase.FLYING, other)
    bench.publish(0.01, Phase.OVER, other)
    assert not bench.companion.process_messages()
    assert other.receive() == [] and bench.companion.service.flown_s == 0.0
    assert bench.notes == ["note: messages of another station are ignored"]


def test_a_station_that_ends_before_its_flight_is_replaced(vehicle):
    bench = Bench(
        Scenario(supervisor=Supervisor(attitude_outage_s=0.04, attitude_lost_s=0.05)), vehicle
    )
    second = make_station_link(bench.companion.scenario, bench.lcm)
    bench.publish(0.0, Phase.WAITING)

    def waits(flown_s):
        if second.receive():
            raise KeyboardInterrupt
        second.publish(0.0, {})

    with pytest.raises(KeyboardInterrupt):
        bench.companion.serve(waits)
    assert bench.companion.link.station == second.station
    assert len(bench.station.receive()) == 1


def test_waiting_can_be_interrupted(bench):
    def check(flown_s):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bench.companion.serve(check)


def test_without_a_link_the_coordinator_follows_its_own_setpoints(scenario, vehicle):
    """Its input `followed` is unconnected."""
    coordinator = make_coordinator(scenario)
    context = make_context(coordinator, 0)
    assert not coordinator.GetInputPort("followed").HasValue(context)

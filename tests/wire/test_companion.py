"""A coordinator that serves a station that is a script."""

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
        zeros = {name: np.zeros(size) for name, size in self.station.tells.sizes.items()}
        position = np.concatenate([vehicle.p_B, vehicle.working])
        self.sample = zeros | {
            "state": vehicle.trim_state,
            "specific_thrust": np.array([GRAVITY]),
            "rotor_effectiveness": np.ones(len(vehicle.rotors.names)),
            "followed": np.concatenate([position, np.zeros(2 * len(position) + 1)]),
        }

    def tell(self, time, phase=Phase.FLYING, station=None, **parts):
        """By the bench's own station, or another one."""
        station = station or self.station
        station.phase = phase
        station.tell(time, self.sample | parts)

    def answers(self, *times):
        """To samples of these times, one after another."""
        answers = []
        for time in times:
            self.tell(time)
            self.companion.answer()
            answers += self.station.hear()
        return answers


def test_who_waits_is_told_that_it_is_there(bench):
    for _ in range(2):
        bench.tell(0.0, Phase.WAITING)
        bench.companion.answer()
        (answer,) = bench.station.hear()
        assert answer.phase is Phase.WAITING
    assert bench.companion.service.line() == "no flight"


def test_each_tick_is_answered_once(bench):
    answers = bench.answers(*(i * PERIOD for i in range(9)), 0.08, 0.04)
    assert [answer.time for answer in answers] == pytest.approx([0, 0.02, 0.04, 0.06, 0.08])
    assert all(answer.phase is Phase.FLYING for answer in answers)
    assert [answer.parts["segment"][-1] for answer in answers] == pytest.approx(
        [0, 0.02, 0.04, 0.06, 0.08]
    )
    service = bench.companion.service
    assert (len(service.answer_ms), service.missed, service.flown_s) == (5, 0, 0.08)
    assert service.line().startswith("0.08 s, 5 ticks, 0 missed, ")


def test_an_answer_is_what_the_coordinator_says(bench):
    bench.answers(0.0, 0.01)
    (answer,) = bench.answers(0.02)
    m = len(answer.parts["segment"]) // 3
    plan = answer.parts["plan"].reshape(-1, m)
    assert len(plan) == Supervisor().plan_ticks + 2
    # At rest in trim nothing is to be done.
    np.testing.assert_allclose(answer.parts["segment"][: 2 * m], bench.sample["followed"][: 2 * m])
    np.testing.assert_allclose(plan, 0.0, atol=1e-9)
    assert answer.parts["status"][2] == 0


def test_setpoints_begin_where_the_station_has_them(bench):
    bench.answers(0.0, 0.01)
    elsewhere = bench.sample["followed"].copy()
    m = len(elsewhere) // 3
    elsewhere[0] += 0.1
    elsewhere[m] = 0.2
    elsewhere[-1] = 0.01
    bench.tell(0.02, followed=elsewhere)
    bench.companion.answer()
    (answer,) = bench.station.hear()
    assert answer.parts["segment"][0] == pytest.approx(elsewhere[0] + 0.01 * 0.2)
    assert answer.parts["segment"][m] == pytest.approx(0.2)


def test_ticks_without_their_sample_are_missed(bench):
    """And not worked off later."""
    bench.answers(0.0, 0.01, 0.03, 0.11)  # Without 0.02, 0.04, 0.06, 0.08 and 0.1.
    service = bench.companion.service
    assert service.missed == 5 and len(service.tick_ms) == 1
    answer, last = bench.answers(0.12, 0.13, 4.2)
    assert (answer.time, last.time) == (0.12, 4.2)
    assert service.missed == 5 + 203 and len(service.tick_ms) == 3


def test_a_flight_that_has_begun_is_joined(bench):
    assert bench.answers(12.345678) == []
    (answer,) = bench.answers(12.35, 12.36)
    assert answer.time == pytest.approx(12.36)
    assert bench.companion.service.missed == 0


def test_noise_is_not_answered(bench):
    for data in (b"", b"noise", b"\0" * 1000):
        bench.lcm.Publish(STATION, data)
    assert not bench.companion.answer()
    assert bench.companion.link.refused == 3


@pytest.fixture(scope="module")
def hostile_bench(scenario, vehicle):
    bench = Bench(scenario, vehicle)
    bench.answers(0.0)
    return bench


@given(st.data())
def test_absurd_samples_are_not_believed_and_others_survived(hostile_bench, data):
    """Whatever a part holds: what is asked for is finite, and the next sample is taken in."""
    bench = hostile_bench
    begin = bench.companion.service.flown_s
    part = data.draw(st.sampled_from(sorted(bench.sample)))
    size = len(bench.sample[part])
    numbers = st.floats() | st.sampled_from([0.0, 1.0, 9999.0, -9999.0, 1e300])
    value = data.draw(st.lists(numbers, min_size=size, max_size=size).map(np.array))
    bench.tell(begin + 0.02, **{part: value})
    bench.companion.answer()
    for answer in [*bench.station.hear(), *bench.answers(begin + 0.04)]:
        assert np.isfinite(answer.parts["segment"]).all()
        assert np.isfinite(answer.parts["plan"]).all()
    assert bench.companion.service.flown_s == pytest.approx(begin + 0.04)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e5])
@pytest.mark.parametrize("part", ["state", "disturbance", "followed"])
def test_absurd_samples_are_not_answered(bench, part, value):
    bench.answers(0.0, 0.01)
    bench.tell(0.02, **{part: np.full_like(bench.sample[part], value)})
    bench.companion.answer()
    assert bench.station.hear() == []


@pytest.mark.parametrize("time", [1e6, -1.0])
def test_a_time_that_no_flight_comes_to_is_not_believed_and_said(bench, time):
    assert bench.answers(time) == []
    assert bench.companion.link.phase is Phase.WAITING
    assert bench.notes == ["note: samples come that no vehicle has, or of no time of a flight"]


def test_what_is_late_or_told_twice_is_no_news(bench):
    assert len(bench.answers(0.0, 0.01, 0.02, 0.02, 0.01)) == 2
    assert bench.notes == [] and bench.companion.link.refused == 0


def test_it_ends_with_the_flight(bench):
    bench.answers(0.0, 0.01)
    bench.tell(0.02, Phase.OVER)
    service = bench.companion.serve(lambda flown_s: None)
    assert service.fault == "" and service.flown_s == 0.01


def test_another_stations_end_is_not_its_own(bench):
    bench.tell(0.0, Phase.OVER)
    bench.companion.answer()
    assert bench.companion.link.phase is Phase.WAITING


def test_a_station_that_falls_silent_is_dead(vehicle):
    bench = Bench(Scenario(supervisor=Supervisor(attitude_lost_s=0.05)), vehicle)
    bench.answers(0.0, 0.01)
    service = bench.companion.serve(lambda flown_s: None)
    assert service.fault == "no sample of the station for 0.05 s, since 0.01 s"


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
def test_a_station_of_another_scenario_is_refused_and_finds_out(bench, phase, other, differing):
    station = make_station_link(other, bench.lcm)
    bench.tell(0.0, phase, station)
    with pytest.raises(BadInput, match=f"a station of the same .* that differs in {differing}$"):
        bench.companion.answer()
    assert bench.companion.service.answer_ms == []
    with pytest.raises(
        BadInput, match=f"a coordinator of the same .* that differs in {differing}$"
    ):
        station.wait(lambda: None)


def test_of_two_stations_it_serves_the_one_whose_flight_it_begins(bench):
    other = make_station_link(bench.companion.scenario, bench.lcm)
    for phase in (Phase.WAITING, Phase.FLYING):
        bench.tell(0.0, phase)
        bench.tell(0.0, phase, other)
        bench.companion.answer()
        (answer,) = bench.station.hear()
        assert (answer.phase, answer.station) == (phase, bench.station.station)
    bench.tell(0.02, Phase.FLYING, other)
    bench.tell(0.01, Phase.OVER, other)
    assert not bench.companion.answer()
    assert other.hear() == [] and bench.companion.service.flown_s == 0.0
    assert bench.notes == ["note: another station is there, and is not answered"]


def test_a_station_that_has_gone_before_it_flew_makes_room(vehicle):
    bench = Bench(Scenario(supervisor=Supervisor(attitude_lost_s=0.05)), vehicle)
    second = make_station_link(bench.companion.scenario, bench.lcm)
    bench.tell(0.0, Phase.WAITING)

    def waits(flown_s):
        if second.hear():
            raise KeyboardInterrupt
        second.tell(0.0, {})

    with pytest.raises(KeyboardInterrupt):
        bench.companion.serve(waits)
    assert bench.companion.link.station == second.station
    assert len(bench.station.hear()) == 1


def test_waiting_can_be_interrupted(bench):
    def check(flown_s):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bench.companion.serve(check)


def test_alone_the_coordinator_follows_its_own_setpoints(scenario, vehicle):
    """`followed` is for who has others to follow."""
    coordinator = make_coordinator(scenario)
    context = make_context(coordinator, 0)
    assert not coordinator.GetInputPort("followed").HasValue(context)

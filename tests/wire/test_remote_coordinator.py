"""A flight over the link equals the flight without one, but for latency and lost messages."""

import dataclasses

import numpy as np
import pytest
from drake import lcmt_drake_signal
from pydrake.lcm import DrakeLcm

from aerodrake.coordinator import make_coordinator
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.model.mpc.tick import MISSED
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import MpcMissed
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput
from aerodrake.wire.companion import Companion
from aerodrake.wire.link import COORDINATOR, STATION, Link
from aerodrake.wire.message import Phase
from aerodrake.wire.remote_coordinator import (
    make_layouts,
    make_remote_coordinator,
    make_station_link,
)
from tests.lockstep import Lockstep, fly_over

INTERPOLATED = {"p_Ed_m": 1e-9, "v_Ed_m_s": 1e-7, "tool_axis_d": 1e-9}
INTERPOLATED |= {"followed_p_Ed_m": 1e-9, "followed_v_Ed_m_s": 1e-7}
"""Signals that the station interpolates between the stages of the horizon: their tolerances."""

SHORT = {"settle_s": 0.5, "duration": 2.0}


@pytest.fixture(scope="module")
def clover():
    return load_scenario("clover", SHORT)


@pytest.fixture(scope="module")
def local(clover):
    return FlightSimulation(clover).fly()


def names(diagram, count, port):
    return {getattr(diagram, port)(i).get_name() for i in range(getattr(diagram, count)())}


def test_the_ports_are_those_of_the_coordinator(scenario):
    own, remote = (
        make_coordinator(scenario),
        make_remote_coordinator(
            scenario, VehicleModel.load(scenario), make_station_link(scenario, Lockstep())
        ),
    )
    inputs, outputs = ("num_input_ports", "get_input_port"), ("num_output_ports", "get_output_port")
    assert names(remote, *inputs) == names(own, *inputs) - {"followed"}
    assert names(remote, *outputs) == names(own, *outputs) - {"plan", "horizon"}
    for name in names(remote, *outputs):
        assert remote.GetOutputPort(name).size() == own.GetOutputPort(name).size(), name


@pytest.mark.parametrize("name", ["clover", "clover_paper"])
def test_without_latency_the_flight_is_the_same_bit_for_bit(name):
    scenario = load_scenario(name, SHORT)
    local, over = FlightSimulation(scenario).fly(), fly_over(Lockstep(), scenario)
    assert over.exit_reason == local.exit_reason == "completed"
    assert set(over.signals) == set(local.signals)
    for key in set(local.signals) - {"tick_ms", *INTERPOLATED}:
        # Before the first tick no message has arrived.
        np.testing.assert_array_equal(over[key][1:], local[key][1:], err_msg=key)
    for key, tolerance in INTERPOLATED.items():
        np.testing.assert_allclose(over[key], local[key], rtol=0, atol=tolerance, err_msg=key)
    figures = summarize(scenario, local)["mpc"], summarize(scenario, over)["mpc"]
    for key in ("ticks", "missed", "solved_by", "solver_fallbacks"):
        assert figures[0][key] == figures[1][key]


class OtherClock(Lockstep):
    """Link of a station whose samples have times with jitter, an offset and drift."""

    def __init__(self):
        super().__init__()
        self._random = np.random.default_rng(0)

    def Publish(self, channel, buffer):
        signal = lcmt_drake_signal.decode(buffer)
        if channel == STATION and signal.val[0] == Phase.FLYING:
            signal.timestamp = round(1.0001 * signal.timestamp + self._random.uniform(0, 2000))
        super().Publish(channel, signal.encode())


def test_the_clock_of_the_samples_does_not_matter(clover, local):
    lcm = OtherClock()
    over = fly_over(lcm, clover)
    for key in ("p_E_m", "p_B_m", "p_Bd_m", "v_Bd_m_s"):
        np.testing.assert_array_equal(over[key][1:], local[key][1:], err_msg=key)
    assert (lcm.companion.service.missed, lcm.companion.link.rejected) == (0, 0)


def test_latency_hardly_increases_the_error():
    """Without the plan in each message, 3 ms would increase the error by half."""
    scenario = load_scenario("clover", settle_s=0.5, duration=9)
    local, over = FlightSimulation(scenario).fly(), fly_over(Lockstep(late=3), scenario)
    assert summarize(scenario, over)["mpc"]["missed"] == 0
    started = local.time_s > 3
    assert over.error_m[started].mean() < 1.2 * local.error_m[started].mean()


def test_a_reply_within_its_period_is_in_time(clover):
    assert summarize(clover, fly_over(Lockstep(late=17), clover))["mpc"]["missed"] == 0


def test_a_reply_after_its_period_is_a_missed_tick(clover):
    over = fly_over(Lockstep(late=21), clover)
    figures = summarize(clover, over)
    assert figures["mpc"]["ticks"] == 0
    assert figures["mpc"]["missed"] == 125
    assert (over.exit_reason, over.exit_cause.split()[0]) == ("hold", "plan_outage")


def test_lost_messages_hardly_increase_the_error(clover, local):
    """Each fifth reply and each seventh sample are lost, some of them samples of a tick."""
    lcm = Lockstep(2, lambda channel, i: i % {COORDINATOR: 5, STATION: 7}[channel] == 4)
    over = fly_over(lcm, clover)
    figures = summarize(clover, over)["mpc"]
    assert over.exit_reason == "completed"
    assert lcm.companion.service.missed == pytest.approx(125 / 7, abs=2)
    assert figures["missed"] > 25 and figures["missed"] + figures["ticks"] == 125
    assert over["qp_status"].tolist().count(MISSED) > 20
    assert over.error_m.max() < 0.002
    # Setpoints are continuous.
    jumps = np.diff(over["p_Bd_m"], axis=0) - over["v_Bd_m_s"][:-1] * 0.01
    assert np.abs(jumps).max() < 3 * 0.01**2


def test_a_silent_coordinator_leads_to_a_hold_until_it_replies(clover):
    """The plan is followed for `plan_ticks`, then setpoints come to rest until replies arrive."""
    lcm = Lockstep(2, lambda channel, i: channel == COORDINATOR and 60 <= i < 80)
    over = fly_over(lcm, clover)
    mode, age = over["supervisor_mode"], over["plan_age_ticks"]
    hold = np.flatnonzero(mode == SafeMode.HOLD)
    assert age[hold[0] - 1] == pytest.approx(clover.supervisor.plan_ticks, abs=1)
    assert age.max() == pytest.approx(20, abs=1)
    rest = hold[40]
    assert np.abs(over["a_Bd_m_s2"][rest]).max() < 0.3
    assert over.exit_reason == "completed" and mode[-1] == SafeMode.NOMINAL
    assert over.error_m.max() < 0.1 and over.error_m[-1] < 0.005


@pytest.mark.parametrize("late, each", [(12, 1000), (2, 20)], ids=["slow", "lossy"])
def test_a_hold_ends_with_late_or_lost_replies(clover, late, each):
    def is_lost(channel, i):
        return channel == COORDINATOR and (40 <= i < 50 or i > 50 and i % each == 0)

    over = fly_over(Lockstep(late, is_lost), clover)
    assert over.exit_reason == "completed"
    assert np.count_nonzero(over["supervisor_mode"] == SafeMode.HOLD) < 80


def test_a_dead_coordinator_leads_to_a_landing(clover):
    scenario = load_scenario("clover", {**SHORT, "supervisor.plan_lost_s": 0.3})
    over = fly_over(Lockstep(2, lambda channel, i: channel == COORDINATOR and i > 60), scenario)
    assert (over.exit_reason, over.exit_cause.split()[0]) == ("descend", "plan_lost")
    triggers = [
        e["cause"] for e in summarize(scenario, over)["events"] if e["event"] == "triggered"
    ]
    assert triggers[:2] == ["plan_outage", "plan_lost"]
    assert over["v_Bd_m_s"][-1, 2] == pytest.approx(-scenario.supervisor.descend_m_s, rel=0.05)


def test_a_second_station_does_not_change_the_flight(clover, local):
    """Its messages of all phases are between those of the first one, which is served."""
    lcm = Lockstep()
    second = make_station_link(clover, lcm)

    def is_lost(channel, i):
        is_served = lcm.companion and lcm.companion.link.station
        if is_served and channel == STATION and i % 2:
            second.phase = Phase(i // 2 % 3)
            second.publish(i / 200, {})
        return False

    lcm.is_lost = is_lost
    over = fly_over(lcm, clover)
    assert over.exit_reason == "completed"
    for key in set(local.signals) - {"tick_ms", *INTERPOLATED}:
        np.testing.assert_array_equal(over[key][1:], local[key][1:], err_msg=key)
    assert lcm.companion.link.rejected > 200
    assert second.receive() == [] and second.rejected


def test_a_restarted_coordinator_resumes_the_flight(clover):
    lcm = Lockstep(2)

    def is_lost(channel, i):
        if channel == STATION and i == 140:
            lcm.companion = Companion(clover, lcm)
        return channel == COORDINATOR and i > 60 and lcm.companion is first

    lcm.is_lost = is_lost
    flight = FlightSimulation(clover, link=make_station_link(clover, lcm))
    first = lcm.companion = Companion(clover, lcm)
    over = flight.fly()
    assert SafeMode.HOLD in over["supervisor_mode"]
    assert over.exit_reason == "completed"
    assert over.error_m.max() < 0.1 and over.error_m[-1] < 0.005
    assert lcm.companion.service.flown_s == pytest.approx(2.49)


def test_a_tick_that_the_mpc_misses_is_missed_over_the_link_too():
    faults = [MpcMissed(start_s=0.5, duration_s=0.055)]
    scenario = load_scenario("clover", SHORT, faults=faults)
    figures = [
        summarize(scenario, log)["mpc"]
        for log in (FlightSimulation(scenario).fly(), fly_over(Lockstep(3), scenario))
    ]
    assert [f["missed"] for f in figures] == [3, 3]


def test_a_refusal_before_the_flight_is_raised(scenario):
    """The systems receive messages already when they are tried before the flight."""
    lcm, other = DrakeLcm("memq://"), dataclasses.replace(scenario, settle_s=9.0)
    link = make_station_link(scenario, lcm)
    coordinator = Link(lcm, *make_layouts(make_coordinator(other), other), False)
    coordinator.station, coordinator.phase = link.station, Phase.OVER
    coordinator.publish(0.0, {})
    with pytest.raises(BadInput, match=r"expected a coordinator .* that differs in settle_s$"):
        FlightSimulation(scenario, link=link)

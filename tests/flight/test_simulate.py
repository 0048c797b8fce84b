"""Tests of flights: their endings and their logs."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem

import aerodrake.flight.simulate
from aerodrake.flight.recording import Recording
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize, to_json
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import (
    Filter,
    Hover,
    MovingTarget,
    Rates,
    Rotor,
    SampleStale,
    Scenario,
    Sensors,
    Vehicle,
)
from aerodrake.support.errors import BadInput
from aerodrake.wiring.replacements import Replacements
from tests.robots import multibody_plant

WEAK = Vehicle(rotor=Rotor(max_thrust_n=2.0))
"""Four rotors with 8 N in total; the vehicle weighs 37 N."""


def test_a_flight_completes(short_flight):
    scenario, log = short_flight
    assert (log.exit_reason, log.exit_cause) == ("completed", "")
    assert log.wall_s > 0
    assert 0 < log.error_m.max() < 0.05


def test_time_axis(short_flight):
    """Reference time from the hover to the end, each 10 ms, including 0."""
    _, log = short_flight
    np.testing.assert_allclose(log.time_s, np.linspace(-0.1, 0.5, 61), atol=1e-12)
    assert list(log.time_s) == [round(t, 9) for t in log.time_s]  # Windows end on a sample.
    assert log.time_s[10] == 0
    np.testing.assert_array_equal(log["p_Ed_m"][:11], np.tile(log["p_Ed_m"][0], (11, 1)))
    assert np.any(log["p_Ed_m"][20] != log["p_Ed_m"][0])


def test_all_signals_are_as_long_as_the_time_axis(short_flight):
    _, log = short_flight
    for key in set(log.signals) - {"tick_ms"}:
        assert len(log[key]) == 61, key
        assert np.isfinite(log[key]).all(), key
    assert len(log["tick_ms"]) == 30  # 0.6 s, each 20 ms.


@pytest.mark.parametrize(
    ("settle_s", "duration", "ticks"),
    [(0.1, 0.2, 15), (0.0, 0.3, 15), (0.2, 0.4, 30), (0.0, 0.31, 16), (0.013, 0.02, 2)],
)
def test_the_number_of_ticks_is_that_of_periods(settle_s, duration, ticks):
    """0.1 + 0.2 exceeds 0.3 in floating point; a tick at the end does not count."""
    log = FlightSimulation(Scenario(settle_s=settle_s, duration=duration)).fly()
    assert len(log["tick_ms"]) == ticks
    assert len(log.time_s) == int((settle_s + duration) / 0.01 + 1e-9) + 1


def test_logs_are_at_the_flight_controllers_rate():
    rates = Rates(flight_period_s=0.005, sensor_period_s=0.005)
    log = FlightSimulation(Scenario(settle_s=0, duration=0.1, rates=rates)).fly()
    np.testing.assert_allclose(np.diff(log.time_s), 0.005)


def test_progress_is_reported_up_to_the_end():
    times = []
    FlightSimulation(Scenario(settle_s=0.1, duration=0.35)).fly(progress=times.append)
    np.testing.assert_allclose(times, [0.1, 0.2, 0.3, 0.4, 0.45])


# Lost.


def ended(scenario: Scenario):
    """Returns the log of a flight that does not complete; its summary is strict JSON."""
    log = FlightSimulation(scenario).fly()
    figures = summarize(scenario, log)
    assert to_json(figures)
    assert figures["exit_reason"] == log.exit_reason != "completed"
    assert figures["exit_cause"] == log.exit_cause
    assert log.exit_cause and "\n" not in log.exit_cause
    assert log.time_s[-1] < scenario.duration - 0.05
    assert figures["simulated_s"] == pytest.approx(log.time_s[-1] + scenario.settle_s)
    return log


def test_lost_by_error_after_the_approach():
    high = replace(WEAK, base_position_m=(0.0, 0.0, 9.0))
    log = ended(Scenario(reference=Hover(), vehicle=high, settle_s=0, duration=3))
    assert log.exit_reason == "lost" and log.exit_cause.startswith("error of 1.")
    assert log.error_m[-1] > 1.0 and log.error_m[-11] <= 1.0
    # It falls at (37 - 8) / 37 of gravity; the arm moves up and pushes the base further down.
    fallen = 0.5 * 9.81 * (1 - 8 / (3.8 * 9.81)) * log.time_s[-1] ** 2
    assert 9.0 - log["p_B_m"][-1, 2] == pytest.approx(fallen, rel=0.15)


def test_lost_in_the_initial_hover():
    """The vehicle is on the ground before reference time 0."""
    high = replace(WEAK, base_position_m=(0.0, 0.0, 4.0))  # On the ground its arm points up.
    log = ended(Scenario(reference=Hover(), vehicle=high, settle_s=3, duration=1))
    assert log.exit_reason == "lost" and log.time_s[-1] < -1


def test_a_far_target_is_not_lost_before_it_is_approached():
    reference = MovingTarget(target_m=(0.0, 5.0, 0.0))
    log = FlightSimulation(Scenario(reference=reference, settle_s=0, duration=0.4)).fly()
    assert log.exit_reason == "completed" and log.error_m.min() > 4


def test_lost_by_tilt():
    """With 1 m of position noise the vehicle tumbles."""
    sensors = Sensors(position_noise_m=1.0, velocity_noise_m_s=1.0)
    scenario = Scenario(reference=MovingTarget(), sensors=sensors, settle_s=0.5, duration=4)
    log = ended(replace(scenario, filter=Filter(kind="none")))
    assert log.exit_reason == "lost" and log.exit_cause.startswith("tilt of ")
    w, x, y, z = log["quaternion"][-1]
    tilt = np.degrees(np.arccos(1 - 2 * (x**2 + y**2) / (w**2 + x**2 + y**2 + z**2)))
    assert tilt > 60
    assert f"tilt of {tilt:.0f} deg" in log.exit_cause


@pytest.mark.parametrize("number", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize("part", ["positions", "velocities"])
def test_lost_by_a_state_that_is_not_finite_or_too_large(number, part, monkeypatch):
    scenario = Scenario(settle_s=0, duration=1)
    flight = FlightSimulation(scenario)
    contexts = []

    def make_context(*arguments):
        contexts.append(made := original(*arguments))
        return made

    original = aerodrake.flight.simulate.make_context
    monkeypatch.setattr(aerodrake.flight.simulate, "make_context", make_context)
    plant = multibody_plant(flight.closed_loop)

    def poison(t):
        if t >= 0.2:
            state = plant.GetMyMutableContextFromRoot(contexts[0])
            last = {"positions": plant.num_positions(), "velocities": state.num_total_states()}
            state.get_mutable_discrete_state_vector().SetAtIndex(last[part] - 1, number)

    log = flight.fly(progress=poison)
    assert log.exit_reason == "lost"
    verb = "diverges" if number == 1e200 else "is not finite"
    assert log.exit_cause.startswith(f"the state {verb} at 0.") and "\n" not in log.exit_cause
    assert 0.2 <= log.time_s[-1] <= 0.3
    assert to_json(summarize(scenario, log))


# Interrupted, and bugs.


def raising(error: BaseException, after_s: float):
    def progress(t):
        if t >= after_s:
            raise error

    return progress


def test_an_interrupt_keeps_what_was_flown(short_flight):
    scenario, whole = short_flight
    log = FlightSimulation(scenario).fly(progress=raising(KeyboardInterrupt(), 0.3))
    assert (log.exit_reason, log.exit_cause) == ("interrupted", "at 0.20 s")
    assert len(log.time_s) == 31 and len(log["tick_ms"]) == 15
    for key in set(whole.signals) - {"tick_ms"}:
        np.testing.assert_array_equal(log[key], whole[key][:31], err_msg=key)


def test_a_defect_is_not_reported_as_a_lost_flight(short_flight):
    with pytest.raises(RuntimeError, match="^a bug$"):
        FlightSimulation(short_flight[0]).fly(progress=raising(RuntimeError("a bug"), 0.1))


class Defect(LeafSystem):
    """An allocator whose output raises an exception."""

    def __init__(self, error: BaseException):
        super().__init__()
        self.DeclareVectorInputPort("d_g", 1)
        self.DeclareVectorInputPort("distances", 2)
        self.DeclareVectorOutputPort("weights", 5, lambda context, output: fail(error))


def fail(error: BaseException):
    raise error


@pytest.mark.parametrize("error", [RuntimeError("a bug"), BadInput("file", "", "a refusal")])
def test_making_a_flight_raises_what_its_first_tick_raises(short_flight, error):
    replacements = Replacements({"weight_allocator": lambda ours: Defect(error)})
    with pytest.raises(type(error), match="a bug|a refusal"):
        FlightSimulation(short_flight[0], replacements)


def test_a_flight_can_be_flown_again_after_an_interrupt(short_flight):
    scenario, whole = short_flight
    flight = FlightSimulation(scenario)
    flight.fly(progress=raising(KeyboardInterrupt(), 0.2))
    again = flight.fly()
    np.testing.assert_array_equal(again["p_E_m"], whole["p_E_m"])
    assert len(again["tick_ms"]) == len(whole["tick_ms"])


@pytest.mark.parametrize("is_written", [True, False])
def test_an_interrupt_while_samples_are_moved_neither_loses_nor_doubles_any(
    short_flight, monkeypatch, is_written
):
    scenario, whole = short_flight
    append, interrupts = Recording.append, iter([True])

    def interrupted(recording, times, samples):
        if is_written:
            append(recording, times, samples)
        if next(interrupts, False):
            raise KeyboardInterrupt
        if not is_written:
            append(recording, times, samples)

    monkeypatch.setattr(Recording, "append", interrupted)
    monkeypatch.setattr("aerodrake.flight.simulate.LOG_SAMPLES", 50)
    log = FlightSimulation(scenario).fly()
    assert log.exit_reason == "interrupted"
    np.testing.assert_array_equal(log.time_s, whole.time_s[: len(log.time_s)])
    np.testing.assert_array_equal(log["p_B_m"], whole["p_B_m"][: len(log.time_s)])
    assert len(log.time_s) >= 50


def test_a_flight_without_network_needs_no_torch():
    """Summary and replay do not import torch either, which takes a second.

    Processes of sweeps and trainings do not import matplotlib.
    """
    code = (
        "import sys; from aerodrake.scenario import Scenario\n"
        "import aerodrake.sweeps.trial, aerodrake.learning.collection\n"
        "assert not {'torch', 'matplotlib'} & set(sys.modules)\n"
        "from aerodrake.flight.simulate import FlightSimulation\n"
        "import aerodrake.reports.flight_folder, aerodrake.reports.replay\n"
        "FlightSimulation(Scenario(settle_s=0, duration=0.02)).fly()\n"
        "assert 'torch' not in sys.modules"
    )
    root = Path(aerodrake.__file__).parents[1]
    environment = os.environ | {"PYTHONPATH": str(root)}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


@pytest.mark.parametrize("start_s", [1.0, 1.05])
def test_the_sample_at_which_a_flight_stops_is_logged_once(start_s):
    """The monitor checks the flight at that time, or later."""
    fault = SampleStale(group="attitude", start_s=start_s, duration_s=9.0)
    log = FlightSimulation(Scenario(settle_s=0.5, duration=2.0, faults=(fault,))).fly()
    assert (log.exit_reason, log.exit_cause.split()[0]) == ("stopped", "attitude_lost")
    assert log.time_s[-1] == pytest.approx(start_s + 0.4)
    np.testing.assert_allclose(np.diff(log.time_s), 0.01)
    assert list(log["supervisor_mode"][-2:]) == [SafeMode.HOLD, SafeMode.STOP]

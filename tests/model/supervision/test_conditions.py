"""Conditions: when they trigger, when they clear, and which mode wins; stepped as in flight."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.supervision.conditions import (
    NEVER,
    Condition,
    Rules,
    Signal,
    conditions,
    signals,
    supervise,
)
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import Supervisor

DT = 0.01
HOLD, DESCEND, STOP = SafeMode.HOLD, SafeMode.DESCEND, SafeMode.STOP


class Stepper:
    """Conditions, stepped with one value for each signal at a time."""

    def __init__(self, *conditions: Condition):
        self.rules = Rules.of(conditions)
        self.active = self.since = np.zeros(len(conditions))
        self.signals = np.zeros(len(Signal))

    def step(self, times: int = 1, **values: float) -> tuple[SafeMode, int]:
        for name, value in values.items():
            self.signals[Signal[name]] = value
        for _ in range(times):
            mode, cause, self.active, self.since = supervise(
                self.rules, self.active, self.since, self.signals, DT
            )
        return SafeMode(int(mode)), int(cause)


@pytest.fixture
def tilt() -> Stepper:
    """Holds from 1 rad on after 30 ms; clears at 0.5 rad after 50 ms."""
    return Stepper(Condition("tilt", Signal.TILT, HOLD, 1.0, 0.03, 0.5, 0.05))


def test_nothing_is_the_matter(tilt):
    assert tilt.step(100) == (SafeMode.NOMINAL, -1)


def test_a_condition_triggers_after_its_time_and_not_before(tilt):
    for _ in range(3):
        assert tilt.step(TILT=1.0) == (SafeMode.NOMINAL, -1)
    assert tilt.step() == (HOLD, 0)


def test_what_does_not_last_does_not_trigger(tilt):
    for _ in range(10):
        assert tilt.step(3, TILT=1.2)[0] is SafeMode.NOMINAL
        assert tilt.step(1, TILT=0.99)[0] is SafeMode.NOMINAL


def test_it_clears_below_its_own_threshold_after_its_own_time(tilt):
    tilt.step(4, TILT=1.0)
    assert tilt.step(1000, TILT=0.51) == (HOLD, 0)  # Hysteresis.
    assert tilt.step(5, TILT=0.5) == (HOLD, 0)
    tilt.step(TILT=0.51)
    assert tilt.step(5, TILT=0.0) == (HOLD, 0)  # It counts anew.
    assert tilt.step() == (SafeMode.NOMINAL, -1)


def test_what_is_for_good_is_never_cleared():
    stepper = Stepper(Condition("rotor_lost", Signal.ROTOR_MISSING, STOP, 0.6, 0, 0, NEVER))
    assert stepper.step(ROTOR_MISSING=1.0) == (STOP, 0)
    assert stepper.step(100_000, ROTOR_MISSING=0.0) == (STOP, 0)


def test_what_is_no_number_triggers_and_never_clears(tilt):
    assert tilt.step(4, TILT=math.nan) == (HOLD, 0)
    assert tilt.step(100) == (HOLD, 0)


def test_the_worst_wins_and_the_first_of_the_worst_is_the_cause():
    stepper = Stepper(
        Condition("known", Signal.SATURATED, SafeMode.NOMINAL, 1, 0, 0, 0),
        Condition("hold", Signal.TILT, HOLD, 1, 0, 0, 0),
        Condition("descend", Signal.PLAN_AGE, DESCEND, 1, 0, 0, 0),
        Condition("too", Signal.PLAN_AGE_S, DESCEND, 1, 0, 0, 0),
    )
    assert stepper.step(SATURATED=1) == (SafeMode.NOMINAL, 0)
    assert stepper.step(PLAN_AGE_S=1) == (DESCEND, 3)
    assert stepper.step(TILT=1) == (DESCEND, 3)
    assert stepper.step(PLAN_AGE=1) == (DESCEND, 2)
    assert stepper.step(PLAN_AGE=0, PLAN_AGE_S=0) == (HOLD, 1)
    assert stepper.step(TILT=0) == (SafeMode.NOMINAL, 0)
    assert stepper.step(SATURATED=0) == (SafeMode.NOMINAL, -1)


@given(
    st.lists(st.floats(0, 2), min_size=1, max_size=80),
    st.integers(0, 8),
    st.integers(0, 8),
    st.floats(0.3, 1.5),
    st.floats(0, 1),
)
def test_trigger_and_clear_are_what_they_say(values, trigger_steps, clear_steps, trigger, share):
    """Against the rules by their words: all of the last values above, or all below."""
    clear = share * trigger * 0.99
    stepper = Stepper(
        Condition("c", Signal.TILT, HOLD, trigger, trigger_steps * DT, clear, clear_steps * DT)
    )
    is_active, began = False, 0
    for k, value in enumerate(values):
        mode, _ = stepper.step(TILT=value)
        steps = clear_steps if is_active else trigger_steps
        recent = values[max(began, k - steps) : k + 1]
        contrary = [v <= clear if is_active else v >= trigger for v in recent]
        if len(recent) == steps + 1 and all(contrary):
            is_active, began = not is_active, k + 1
        assert mode is (HOLD if is_active else SafeMode.NOMINAL)


def test_each_condition_has_a_name_of_its_own_and_a_sound_rule():
    found = conditions(Supervisor())
    assert len({condition.name for condition in found}) == len(found)
    for condition in found:
        assert condition.clear < condition.trigger
        assert condition.clear_s >= 0 and condition.trigger_s >= 0
        assert (condition.clear_s == NEVER) == (condition.mode >= DESCEND), condition.name
    assert {condition.signal for condition in found} == set(Signal)


def watched(vehicle, **values) -> np.ndarray:
    given = {
        "state": vehicle.trim_state,
        "feet": -0.38,
        "mode": 0.0,
        "thrust": 9.8,
        "plan_age": 0.0,
        "period": 0.02,
        "outage": np.zeros(3),
        "effectiveness": np.ones(4),
        "saturated": 0.0,
        "verdict": 0.0,
        "learner": 1.0,
    }
    return signals(*(given | values).values())


def test_in_trim_no_signal_says_anything(vehicle):
    np.testing.assert_array_equal(watched(vehicle), np.zeros(len(Signal)))


def test_signals_stand_where_their_names_say(vehicle):
    cases = {
        "PLAN_AGE": ({"plan_age": 3.0}, 3.0),
        "PLAN_AGE_S": ({"plan_age": 3.0}, 0.06),
        "POSITION_OUTAGE": ({"outage": np.array([0.3, 0, 0])}, 0.3),
        "ATTITUDE_OUTAGE": ({"outage": np.array([0, 0.4, 0])}, 0.4),
        "JOINTS_OUTAGE": ({"outage": np.array([0, 0, 0.5])}, 0.5),
        "ROTOR_MISSING": ({"effectiveness": np.array([1, 0.8, 0.9, 1])}, 0.2),
        "SATURATED": ({"saturated": 1.0}, 1.0),
        "REFERENCE_NOT_FINITE": ({"verdict": 1.0}, 1.0),
        "REFERENCE_OUT_OF_REACH": ({"verdict": 2.0}, 1.0),
        "REFERENCE_TOO_FAST": ({"verdict": 3.0}, 1.0),
        "REFERENCE_JUMPED": ({"verdict": 4.0}, 1.0),
        "LEARNER_SHUT_OUT": ({"learner": 2.0}, 1.0),
    }
    for name, (values, expected) in cases.items():
        found = watched(vehicle, **values)
        assert found[Signal[name]] == pytest.approx(expected), name
        others = set(np.flatnonzero(found)) - {Signal[name]}
        assert others <= {Signal.PLAN_AGE, Signal.PLAN_AGE_S}, name


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
def test_tilt_is_the_angle_of_the_rotors_axis(vehicle, angle):
    state = vehicle.trim_state
    axis = np.array([0.6, 0.8, 0.0])
    state[:4] = np.cos(angle / 2), *np.sin(angle / 2) * axis
    assert watched(vehicle, state=state)[Signal.TILT] == pytest.approx(angle)


@pytest.mark.parametrize(
    ("height", "mode", "thrust", "outage", "told"),
    [
        (0.38, 0.0, 9.8, 0.0, {Signal.ON_GROUND}),
        (0.38, 1.0, 9.8, 0.0, {Signal.ON_GROUND}),
        (0.385, 0.0, 9.8, 0.0, set()),
        (0.38, 2.0, 8.0, 0.0, {Signal.LANDED}),
        (0.38, 3.0, 8.0, 0.0, {Signal.LANDED}),
        (0.44, 2.0, 8.0, 0.0, {Signal.LANDED}),
        (0.38, 2.0, 9.8, 0.0, set()),
        (0.48, 2.0, 8.0, 0.0, set()),
        (0.37, 2.0, 8.0, 0.5, {Signal.GROUND_EXPECTED}),
        (0.39, 2.0, 8.0, 0.5, set()),
    ],
)
def test_a_landing_takes_ground_that_carries_and_measurements(
    vehicle, height, mode, thrust, outage, told
):
    state = vehicle.trim_state
    state[6] = height
    found = watched(
        vehicle, state=state, mode=mode, thrust=thrust, outage=np.array([outage, 0.0, 0.0])
    )
    ground = {Signal.ON_GROUND, Signal.LANDED, Signal.GROUND_EXPECTED}
    assert {signal for signal in ground if found[signal]} == told


def test_a_state_that_is_no_number_is_told_and_nothing_else(vehicle):
    state = vehicle.trim_state
    state[[0, 6]] = np.nan
    assert list(np.flatnonzero(watched(vehicle, state=state))) == [Signal.NOT_FINITE]


@pytest.mark.parametrize("plan_ticks", [1, 2, 5])
def test_what_clears_a_condition_does_not_trigger_it(plan_ticks):
    for condition in conditions(Supervisor(plan_ticks=plan_ticks)):
        assert condition.clear < condition.trigger, condition.name

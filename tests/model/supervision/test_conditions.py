"""Tests of conditions: triggering, clearing, and the mode and cause, stepped as in flight."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.sensing.sample_health import Verdict
from aerodrake.model.supervision.conditions import (
    NEVER,
    Condition,
    ConditionTable,
    FlightStatus,
    Signal,
    SupervisorState,
    compute_signals,
    conditions,
    supervise,
)
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import Supervisor

DT = 0.01
HOLD, DESCEND, STOP = SafeMode.HOLD, SafeMode.DESCEND, SafeMode.STOP


class Stepper:
    """Steps conditions with given values of their signals."""

    def __init__(self, *conditions: Condition):
        self.table = ConditionTable.make(conditions)
        self.state = SupervisorState.initial(len(conditions))
        self.signals = np.zeros(len(Signal))

    def step(self, times: int = 1, **values: float) -> tuple[SafeMode, int]:
        for name, value in values.items():
            self.signals[Signal[name]] = value
        for _ in range(times):
            self.state = supervise(self.table, self.state, self.signals, DT)
        return SafeMode(self.state.mode), self.state.cause


@pytest.fixture
def tilt() -> Stepper:
    """HOLD after 30 ms at 1 rad or more; clears after 50 ms at 0.5 rad or less."""
    return Stepper(Condition("tilt", Signal.TILT, HOLD, 1.0, 0.03, 0.5, 0.05))


def test_nominal_without_an_active_condition(tilt):
    assert tilt.step(100) == (SafeMode.NOMINAL, -1)


def test_triggers_after_its_duration(tilt):
    for _ in range(3):
        assert tilt.step(TILT=1.0) == (SafeMode.NOMINAL, -1)
    assert tilt.step() == (HOLD, 0)


def test_short_excursions_do_not_trigger(tilt):
    for _ in range(10):
        assert tilt.step(3, TILT=1.2)[0] is SafeMode.NOMINAL
        assert tilt.step(1, TILT=0.99)[0] is SafeMode.NOMINAL


def test_clears_below_its_second_threshold_after_its_second_duration(tilt):
    tilt.step(4, TILT=1.0)
    assert tilt.step(1000, TILT=0.51) == (HOLD, 0)  # Hysteresis.
    assert tilt.step(5, TILT=0.5) == (HOLD, 0)
    tilt.step(TILT=0.51)
    assert tilt.step(5, TILT=0.0) == (HOLD, 0)  # The duration begins again.
    assert tilt.step() == (SafeMode.NOMINAL, -1)


def test_a_permanent_condition_never_clears():
    stepper = Stepper(Condition("rotor_lost", Signal.ROTOR_LOSS, STOP, 0.6, 0, 0, NEVER))
    assert stepper.step(ROTOR_LOSS=1.0) == (STOP, 0)
    assert stepper.step(100_000, ROTOR_LOSS=0.0) == (STOP, 0)


def test_nan_triggers_and_does_not_clear(tilt):
    assert tilt.step(4, TILT=math.nan) == (HOLD, 0)
    assert tilt.step(100) == (HOLD, 0)


def test_the_first_condition_of_the_worst_mode_is_the_cause():
    stepper = Stepper(
        Condition("report", Signal.SATURATED, SafeMode.NOMINAL, 1, 0, 0, 0),
        Condition("hold", Signal.TILT, HOLD, 1, 0, 0, 0),
        Condition("descend", Signal.PLAN_AGE, DESCEND, 1, 0, 0, 0),
        Condition("descend_too", Signal.PLAN_AGE_S, DESCEND, 1, 0, 0, 0),
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
def test_agrees_with_the_definition(values, trigger_steps, clear_steps, trigger, share):
    """A condition changes after its duration with all values at or beyond the threshold."""
    clear = share * trigger * 0.99
    stepper = Stepper(
        Condition("c", Signal.TILT, HOLD, trigger, trigger_steps * DT, clear, clear_steps * DT)
    )
    is_active, began = False, 0
    for k, value in enumerate(values):
        mode, _ = stepper.step(TILT=value)
        steps = clear_steps if is_active else trigger_steps
        recent = values[max(began, k - steps) : k + 1]
        is_met = [v <= clear if is_active else v >= trigger for v in recent]
        if len(recent) == steps + 1 and all(is_met):
            is_active, began = not is_active, k + 1
        assert mode is (HOLD if is_active else SafeMode.NOMINAL)


def test_conditions_have_unique_names_and_consistent_thresholds():
    table = conditions(Supervisor())
    assert len({condition.name for condition in table}) == len(table)
    for condition in table:
        assert condition.clear < condition.trigger
        assert condition.clear_s >= 0 and condition.trigger_s >= 0
        assert (condition.clear_s == NEVER) == (condition.mode >= DESCEND), condition.name
    assert {condition.signal for condition in table} == set(Signal)


def signals_with(vehicle, **values) -> np.ndarray:
    """Returns the signals in trim, with some quantities replaced."""
    trim = FlightStatus(
        state=vehicle.trim_state,
        mode=int(SafeMode.NOMINAL),
        specific_thrust=9.8,
        plan_age=0.0,
        outage_s=np.zeros(3),
        verdicts=np.zeros(3),
        joint_oscillation=np.zeros(6),
        torque_at_limit=np.zeros(6),
        rotor_effectiveness=np.ones(4),
        saturated=0.0,
        reference_verdict=0.0,
        learner_cause=1.0,
    )
    return compute_signals(trim._replace(**values), -0.38, 0.02, 0.5)


def test_all_signals_are_zero_in_trim(vehicle):
    np.testing.assert_array_equal(signals_with(vehicle), np.zeros(len(Signal)))


def test_each_quantity_is_at_the_index_of_its_signal(vehicle):
    cases = {
        "PLAN_AGE": ({"plan_age": 3.0}, 3.0),
        "PLAN_AGE_S": ({"plan_age": 3.0}, 0.06),
        "POSITION_OUTAGE": ({"outage_s": np.array([0.3, 0, 0])}, 0.3),
        "ATTITUDE_OUTAGE": ({"outage_s": np.array([0, 0.4, 0])}, 0.4),
        "JOINTS_OUTAGE": ({"outage_s": np.array([0, 0, 0.5])}, 0.5),
        "ROTOR_LOSS": ({"rotor_effectiveness": np.array([1, 0.8, 0.9, 1])}, 0.2),
        "SATURATED": ({"saturated": 1.0}, 1.0),
        "REFERENCE_NOT_FINITE": ({"reference_verdict": 1.0}, 1.0),
        "REFERENCE_OUT_OF_REACH": ({"reference_verdict": 2.0}, 1.0),
        "REFERENCE_TOO_FAST": ({"reference_verdict": 3.0}, 1.0),
        "REFERENCE_JUMPED": ({"reference_verdict": 4.0}, 1.0),
        "LEARNER_GATED": ({"learner_cause": 2.0}, 1.0),
        "POSITION_RESET": ({"verdicts": np.array([5.0, 0, 0])}, 1.0),
        "JOINT_OSCILLATION": ({"joint_oscillation": np.array([0, 0, 0.6, 0.2, 0, 0])}, 0.6),
        "TORQUE_AT_LIMIT": ({"torque_at_limit": np.array([0, 0, 0, 1.0, 0, 0])}, 1.0),
    }
    for name, (values, expected) in cases.items():
        signals = signals_with(vehicle, **values)
        assert signals[Signal[name]] == pytest.approx(expected), name
        others = set(np.flatnonzero(signals)) - {Signal[name]}
        assert others <= {Signal.PLAN_AGE, Signal.PLAN_AGE_S}, name


@pytest.mark.parametrize(
    ("amplitude", "verdict", "outage_s"),
    [
        (0.5, Verdict.JUMP, 0.0),
        (0.49, Verdict.JUMP, 0.4),
        (3.0, Verdict.STALE, 0.4),
        (3.0, Verdict.FROZEN, 0.4),
        (3.0, Verdict.NOT_FINITE, 0.4),
        (0.0, Verdict.JUMP, 0.4),
    ],
)
def test_samples_of_oscillating_joints_are_not_missing(vehicle, amplitude, verdict, outage_s):
    signals = signals_with(
        vehicle,
        outage_s=np.array([0, 0, 0.4]),
        verdicts=np.array([0.0, 0.0, verdict]),
        joint_oscillation=np.array([0, amplitude, 0, 0, 0, 0]),
    )
    assert signals[Signal.JOINTS_OUTAGE] == outage_s
    assert signals[Signal.JOINT_OSCILLATION] == amplitude


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
def test_tilt_is_the_angle_of_the_thrust_axis_from_the_vertical(vehicle, angle):
    state = vehicle.trim_state
    axis = np.array([0.6, 0.8, 0.0])
    state[:4] = np.cos(angle / 2), *np.sin(angle / 2) * axis
    assert signals_with(vehicle, state=state)[Signal.TILT] == pytest.approx(angle)


@pytest.mark.parametrize(
    ("height", "mode", "thrust", "outage_s", "expected"),
    [
        (0.38, SafeMode.NOMINAL, 9.8, 0.0, {Signal.ON_GROUND}),
        (0.38, HOLD, 9.8, 0.0, {Signal.ON_GROUND}),
        (0.385, SafeMode.NOMINAL, 9.8, 0.0, set()),
        (0.38, DESCEND, 8.0, 0.0, {Signal.LANDED}),
        (0.38, STOP, 8.0, 0.0, {Signal.LANDED}),
        (0.44, DESCEND, 8.0, 0.0, {Signal.LANDED}),
        (0.38, DESCEND, 9.8, 0.0, set()),
        (0.48, DESCEND, 8.0, 0.0, set()),
        (0.37, DESCEND, 8.0, 0.5, {Signal.GROUND_EXPECTED}),
        (0.39, DESCEND, 8.0, 0.5, set()),
    ],
)
def test_landed_needs_position_samples_and_the_ground_to_carry_weight(
    vehicle, height, mode, thrust, outage_s, expected
):
    state = vehicle.trim_state
    state[6] = height
    signals = signals_with(
        vehicle,
        state=state,
        mode=int(mode),
        specific_thrust=thrust,
        outage_s=np.array([outage_s, 0.0, 0.0]),
    )
    ground = {Signal.ON_GROUND, Signal.LANDED, Signal.GROUND_EXPECTED}
    assert {signal for signal in ground if signals[signal]} == expected


def test_nan_in_the_state_raises_no_other_signal(vehicle):
    state = vehicle.trim_state
    state[[0, 6]] = np.nan
    assert list(np.flatnonzero(signals_with(vehicle, state=state))) == [Signal.NOT_FINITE]


@pytest.mark.parametrize("plan_ticks", [1, 2, 5])
def test_a_value_that_clears_a_condition_does_not_trigger_it(plan_ticks):
    for condition in conditions(Supervisor(plan_ticks=plan_ticks)):
        assert condition.clear < condition.trigger, condition.name

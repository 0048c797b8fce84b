"""Arguments are checked against their annotations."""

import re
from collections.abc import Sequence
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.support.arguments import (
    Axes,
    Count,
    Duration,
    Interval,
    Period,
    Seed,
    StateVector,
    Timed,
    Vector3,
    check_whole,
    checked,
)
from aerodrake.support.errors import BadInput


class Gains:
    def __init__(self, dt):
        self.dt = dt


class Controller:
    @checked
    def __init__(
        self,
        period: Period = 0.02,
        joints: Count = 6,
        names: Sequence[str] = (),
        gains: Annotated[Gains, Timed("dt")] | None = None,
        share: Annotated[float, Interval(0.0, 1.0, "1")] = 0.5,
    ):
        """Documented."""
        self.period = period


@checked
def vectors(state: StateVector = (0.0,) * 13, point: Vector3 = (0, 0, 0), axes: Axes = (0.0,) * 3):
    return state


@pytest.mark.parametrize(
    ("function", "arguments", "expected"),
    [
        (Controller, {"period": 0.0}, "Controller: period: expected more than 0 s, got 0.0"),
        (Controller, {"period": 1e400}, "Controller: period: expected a number, got inf"),
        (Controller, {"period": np.bool_(True)}, "Controller: period: expected a number, got"),
        (Controller, {"period": 1j}, "Controller: period: expected a number, got 1j"),
        (Controller, {"joints": 0}, "Controller: joints: expected 1 or more, got 0"),
        (Controller, {"joints": 2.0}, "Controller: joints: expected a whole number, got 2.0"),
        (Controller, {"names": "ab"}, "Controller: names: expected a list of str, got 'ab'"),
        (
            Controller,
            {"names": ["a", 3]},
            "Controller: names: expected a list of str, got ['a'",
        ),
        (Controller, {"gains": 3}, "Controller: gains: expected Gains or None, got 3"),
        (Controller, {"share": 1.1}, "Controller: share: expected a number in [0, 1] 1, got 1.1"),
        (vectors, {"state": np.zeros(14)}, "vectors: state: expected an array of 13 + 2 n numbers"),
        (vectors, {"state": np.zeros((13, 1))}, "vectors: state: expected an array of 13 + 2 n"),
        (vectors, {"state": np.zeros(11)}, "vectors: state: expected an array of 13 + 2 n"),
        (vectors, {"point": [0, 0]}, "vectors: point: expected an array of 3 numbers, got 2"),
        (vectors, {"point": 3.0}, "vectors: point: expected an array of 3 numbers, got a number"),
        (
            vectors,
            {"point": "abc"},
            "vectors: point: expected an array of finite numbers",
        ),
        (vectors, {"point": [0, np.nan, 0]}, "vectors: point: expected an array of finite numbers"),
        (vectors, {"axes": [0.0, 0.0]}, "vectors: axes: expected an array of 3 + 1 n numbers"),
    ],
)
def test_a_wrong_argument_is_named(function, arguments, expected):
    with pytest.raises(BadInput) as caught:
        function(**arguments)
    assert str(caught.value).startswith(expected)


def test_valid_arguments_are_passed_on_unchanged():
    state = np.zeros(25)
    assert vectors(state) is state and vectors(state=[0] * 15) == [0] * 15
    assert Controller(np.float32(0.5), np.int64(2), ["a"], Gains(1), 1).period == np.float32(0.5)
    assert Controller.__init__.__doc__ == "Documented."


@pytest.mark.parametrize("value", [0, 11, 2.0, True, "3", None])
def test_a_whole_number_is_within_its_range(value):
    check_whole("jobs", np.int64(10), 1, 10)
    expected = f"jobs: expected a whole number in [1, 10], got {value!r}"
    with pytest.raises(BadInput, match=re.escape(expected)):
        check_whole("jobs", value, 1, 10)


def test_missing_and_unknown_arguments_are_errors_of_python():
    with pytest.raises(TypeError, match="perod"):
        Controller(perod=0.1)


@given(st.floats() | st.integers())
def test_ranges_are_those_of_comparisons(number):
    @checked
    def times(period: Period, duration: Duration, seed: Seed):
        return True

    is_finite = abs(number) < float("inf")
    is_whole = isinstance(number, int) and 0 <= number < 2**31
    for arguments, is_valid in (
        ((number, 0, 0), is_finite and number > 0),
        ((1, number, 0), is_finite and number >= 0),
        ((1, 0, number), is_whole),
    ):
        if is_valid:
            assert times(*arguments)
        else:
            with pytest.raises(BadInput):
                times(*arguments)

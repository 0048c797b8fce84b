"""Verdicts and sentences of an analysis."""

from dataclasses import replace

import pytest

from tests.analyses import made, mode, point


def test_an_unstable_mode_is_named_with_frequency_and_growth():
    assert point(5.0).sentence == "unstable in hover: roll at 9.6 Hz grows by 5.0 1/s"
    half = mode(5.0, 9.6, ("mpc", 0.4), ("roll", 0.3), ("joint_2", 0.2))
    shared = replace(point(5.0), modes=(half,), time_s=1.5)
    assert shared.sentence == "unstable at 1.50 s: roll and joint_2 at 9.6 Hz grow by 5.0 1/s"


def test_the_sentence_is_of_the_first_unstable_point():
    stable = made(times=(1.0, 2.0))
    assert stable.is_stable
    assert stable.sentence == "stable in hover: roll at 9.6 Hz decays by 2.0 1/s"
    later = made(times=(1.0, 4.0))
    assert not later.is_stable and later.sentence.startswith("unstable at 4.00 s: roll")


@pytest.mark.parametrize("growth", [1e-12, -1e-12])
def test_constants_are_not_the_least_damped(growth):
    """Their damping ratio is a matter of rounding."""
    constant = replace(mode(growth, 0.0, ("sensors", 1.0)), is_stable=True)
    both = replace(point(-2.0), modes=(constant, *point(-2.0).modes))
    assert both.least_damped[0].participants[0].name == "roll"


def test_a_motion_is_named_once():
    alone = replace(point(5.0), modes=(mode(5.0, 9.6, ("roll", 0.4), ("mpc", 0.1)),))
    assert alone.sentence == "unstable in hover: roll at 9.6 Hz grows by 5.0 1/s"


def test_the_fastest_growing_mode_is_the_first():
    """A growth without oscillation has a damping ratio of -1."""
    slow, fast = mode(0.7, 0.0, ("x", 1.0)), mode(4.0, 3.8, ("pitch", 1.0))
    both = replace(point(5.0), modes=(fast, slow))
    assert both.least_damped == (fast, slow) and "3.8 Hz grows by 4.0 1/s" in both.sentence

"""Hover that an analysis linearises."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerodrake.analysis import analyze
from aerodrake.analysis.modes import are_stable
from aerodrake.scenario import Filter, Rates, Wind
from tests.arms import DESIGNS, arm_scenario


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    """An arm of two joints, and long steps of the plant."""
    arm = arm_scenario(DESIGNS["two"], tmp_path_factory.mktemp("two"))
    return replace(arm, rates=Rates(plant_step_s=0.005), filter=Filter(kind="none"))


def test_a_hover_that_takes_long_is_linearised_at_rest(scenario):
    hover = analyze.analyze_hover(replace(scenario, wind=Wind(velocity_m_s=(6.0, 0.0, 0.0))))
    assert hover.is_stable and hover.is_settled


def test_the_first_period_is_not_linearised():
    """It begins before time 0."""
    long = SimpleNamespace(multiple=lambda time_s: round(time_s / 0.2), start_s=lambda k: 0.2 * k)
    assert analyze._after(long, 0.1) == 0.2
    assert analyze._after(long, 0.5) == pytest.approx(0.4)


def test_slow_modes_of_a_moving_loop_are_stable():
    exponents = np.array([-1.0, 0.01, 0.5, 0.5 + 30j, 5.0])
    assert are_stable(exponents, 0.0).tolist() == [True, True, False, False, False]
    assert are_stable(exponents, 1.0).tolist() == [True, True, True, False, False]

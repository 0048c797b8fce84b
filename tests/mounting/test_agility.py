"""Agility of tools against that of the proposed path."""

import numpy as np
import pytest

from aerodrake.model.reference.closed_curves import CloverCurve
from aerodrake.mounting.agility import NEEDED, attained, cautions
from aerodrake.mounting.joint import Limits
from aerodrake.mounting.scenario_yaml import AMPLITUDE_M, LAP_S
from aerodrake.scenario.references import Clover


def test_the_path_needs_its_derivatives():
    curve = CloverCurve(Clover(amplitude_m=AMPLITUDE_M, lap_s=LAP_S), np.zeros(3))
    times = np.arange(0, LAP_S, 1e-3)
    _, velocity = curve.shape(times)
    acceleration = np.gradient(velocity, times, axis=0)
    for kind, values in (("velocity", velocity), ("acceleration", acceleration)):
        largest = np.linalg.norm(values, axis=1).max()
        assert NEEDED[kind][0] == pytest.approx(largest, rel=1e-3)


@pytest.mark.parametrize(
    ("jacobian", "rate"),
    [
        ([[0.5, 0, 0], [0, 0.2, 0], [0, 0, 9]], 0.4),  # Two directions, of one joint each.
        ([[0.5, 0, 0.1], [0, 0, 0], [0, 0.2, 0]], 0.9),  # One direction; the base has the other.
    ],
)
def test_joints_add_up_in_the_weakest_direction(jacobian, rate):
    assert attained(np.array(jacobian), np.array([1.0, 2.0, 4.0])) == pytest.approx(rate)


def test_small_limits_get_a_caution():
    def kinds(velocity, acceleration):
        limits = [Limits(velocity=velocity, acceleration=acceleration)] * 3
        return [line.split()[4] for line in cautions(0.5 * np.eye(3), limits)]

    assert kinds(3, 15) == [] and kinds(3, 0.3) == ["acceleration"]
    assert kinds(0.1, 0.3) == ["velocity", "acceleration"]

"""Setpoint motions for data collection."""

import math

import numpy as np
import pytest

from aerodrake.model.reference.curves import make_reference
from aerodrake.model.residual.collection_motion import joint_motion, turn_about
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import FigureEight

PERIOD = 0.02


def eight(vehicle, lap_s, length_m=0.15, tilt_rad=0.7):
    times = PERIOD * np.arange(501) - 1.0
    config = FigureEight(length_m=length_m, width_m=length_m / 2, tilt_rad=tilt_rad, lap_s=lap_s)
    motion = make_reference(config, vehicle.p_O).evaluate(times)
    return times, turn_about(vehicle.p_O, motion, times, 20.0)


def test_a_turned_motion_keeps_distance_and_height_and_turns_its_heading():
    centre = np.array([1.0, 2.0, 3.0])
    p = np.tile(centre + [0.1, 0.0, 0.05], (3, 1))
    turned, _ = turn_about(centre, (p, np.zeros((3, 3))), np.array([-4.0, 5.0, 10.0]), 20.0)
    assert turned - centre == pytest.approx(
        np.array([[0.1, 0, 0.05], [0, 0.1, 0.05], [-0.1, 0, 0.05]])
    )


def test_velocity_is_the_derivative_of_the_turned_position(vehicle):
    times, (p, v) = eight(vehicle, lap_s=5.0)
    numeric = (p[2:] - p[:-2]) / (2 * PERIOD)
    assert np.abs(numeric - v[1:-1]).max() < 2e-3 * np.abs(v).max()


def test_the_tool_follows_its_path_within_the_learning_space(scenario, vehicle):
    times, path = eight(vehicle, lap_s=5.0)
    motion = joint_motion(path, vehicle, PERIOD)
    kinematics = Kinematics(vehicle.plant)
    tool = np.array([kinematics.arm(q)[0] for q in motion.vector_values(times - times[0]).T])
    assert np.abs(tool - path[0]).max() < 2e-3
    half = np.array(scenario.allocation.learning_space_m) / 2
    assert (np.abs(tool - vehicle.p_O) <= half + 2e-3).all()
    assert np.abs(tool - vehicle.p_O).max() > 0.06


def test_redundant_motion_returns_to_the_working_configuration(vehicle):
    p = np.tile(vehicle.p_O, (1000, 1))
    turn = np.linspace(0, 2 * math.pi, 500)
    p[:500] += 0.05 * np.column_stack([np.sin(turn), np.cos(turn) - 1, 0 * turn])
    v = np.gradient(p, PERIOD, axis=0)
    motion = joint_motion((p, v), vehicle, PERIOD)
    away, end = (
        np.abs(motion.value(t)[:, 0] - vehicle.working).max() for t in (10.0, motion.end_time())
    )
    assert away > 0.005 and end < 0.05 * away


def test_paths_beyond_the_joint_limits_are_refused(vehicle):
    with pytest.raises(ValueError, match="limits"):
        joint_motion(eight(vehicle, lap_s=1.0)[1], vehicle, PERIOD)

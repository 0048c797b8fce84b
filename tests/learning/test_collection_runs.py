"""Collection runs: their list, and their flights."""

import dataclasses
import math

import numpy as np
import pytest

from aerodrake.learning.collection_runs import (
    CollectionRun,
    circle,
    fly_run,
    paper_runs,
    quick_runs,
    with_disturbances,
)
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import Hover, Payload, Wind

RUNS = paper_runs()


def test_a_circle_has_its_radius_speed_and_plane():
    lap_s = 2 * math.pi * 0.1 / 0.15
    times = 5 + lap_s * np.arange(400) / 400
    p, v = make_reference(circle(0.1, -0.15, 0.7), np.zeros(3)).evaluate(times)
    assert np.linalg.norm(v, axis=1) == pytest.approx(0.15)
    assert np.linalg.norm(p - p.mean(axis=0), axis=1) == pytest.approx(0.1)
    normal = np.array([0.0, -math.sin(0.7), math.cos(0.7)])
    assert np.abs(p @ normal).max() < 1e-12
    back = make_reference(circle(0.1, 0.15, 0.7), np.zeros(3)).evaluate(times)[0]
    assert back * [-1, 1, 1] == pytest.approx(p)


def test_names_are_unique_file_names():
    for runs in (RUNS, quick_runs()):
        names = [run.name for run in runs]
        assert len(set(names)) == len(names)
        assert not any(set(name) & set("/\\ ") for name in names)
        assert {run.role for run in runs} == {"training", "validation", "held_out"}


def test_training_runs_follow_the_paper():
    training = [run for run in RUNS if run.role != "held_out"]
    assert {run.duration_s for run in training} == {150.0}
    assert all(run.wind == Wind() and run.payload == Payload() for run in training)
    bases = [run.base for run in training]
    assert any(isinstance(base, Hover) for base in bases)
    radii = {base.amplitude_m[0] for base in bases if not isinstance(base, Hover)}
    assert radii == {0.10}
    assert len({run.lap_s for run in training}) >= 4


def test_held_out_motions_are_not_trained_on():
    def motion(run):
        return run.lap_s, run.tilt_rad, run.base

    trained = {motion(run) for run in RUNS if run.role != "held_out"}
    held_out = [run for run in RUNS if run.role == "held_out"]
    assert not trained & {motion(run) for run in held_out}
    assert not {base for _, _, base in trained if base != Hover()} & {s.base for s in held_out}


def test_each_held_out_run_is_flown_in_calm_air_in_wind_and_with_a_payload():
    by_name = {run.name: run for run in RUNS}
    held_out = [run for run in RUNS if run.role == "held_out"]
    for run in held_out:
        if run.twin:
            twin = by_name[run.twin]
            changes = {"name": twin.name, "twin": "", "seed": twin.seed}
            like = dataclasses.replace(run, wind=Wind(), payload=Payload(), **changes)
            assert like == twin and (run.wind != Wind()) != (run.payload != Payload())
    winds = [run.wind for run in held_out if any(run.wind.gust_m_s)]
    assert [np.linalg.norm(wind.velocity_m_s) for wind in winds] == pytest.approx([2.0] * 6)
    calm = held_out[0]
    assert [run.name for run in with_disturbances(calm, 0.0, 1)[1:]] == [
        f"{calm.name}_{name}" for name in ("wind", "steady_wind", "payload")
    ]


def test_a_run_records_its_motion_without_the_initial_hover(scenario, vehicle):
    run = CollectionRun("x", "training", 4.0, 5.0, 0.5, circle(0.1, 0.1, 0.4))
    flown = fly_run(scenario, run)
    assert flown.state.shape == (201, 13 + 2 * vehicle.joints)
    assert np.diff(flown.time_s) == pytest.approx(scenario.rates.mpc_period_s)
    p_d = flown.base_setpoint[:, :3] - vehicle.p_B
    assert np.abs(p_d[0]).max() < 1e-3 and np.abs(p_d[-1]).max() > 0.05
    kinematics = Kinematics(vehicle.plant)
    tool = np.array([kinematics.arm(q)[0] for q in flown.joint_setpoint[:, : vehicle.joints]])
    half = np.array(scenario.allocation.learning_space_m) / 2
    assert (np.abs(tool - vehicle.p_O) < half + 2e-3).all()
    assert np.abs(tool - vehicle.p_O).max() > 0.03
    assert np.linalg.norm(flown.state[:, 4:7] - flown.base_setpoint[:, :3], axis=1).max() < 0.05


def test_wind_is_that_of_the_run(scenario):
    calm = CollectionRun("x", "held_out", 1.0, 5.0, 0.0)
    stormy = dataclasses.replace(scenario, wind=Wind(velocity_m_s=(9.0, 0.0, 0.0)))
    assert np.array_equal(fly_run(scenario, calm).state, fly_run(stormy, calm).state)
    windy = dataclasses.replace(calm, wind=Wind(velocity_m_s=(2.0, 0.0, 0.0)))
    away = fly_run(scenario, windy).state - fly_run(scenario, calm).state
    assert (np.abs(away[:, 2]) > 0.01).all()  # Half the pitch angle that compensates the wind.

import dataclasses
import math

import numpy as np
import pytest

from aerodrake.learning.stages import Stage, circle, fly_stage, paper_stages, quick_stages, weathers
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import Hover, Payload, Wind

STAGES = paper_stages()


def test_a_circle_is_round_and_flown_at_its_speed_in_its_plane():
    lap_s = 2 * math.pi * 0.1 / 0.15
    times = 5 + lap_s * np.arange(400) / 400
    p, v = make_reference(circle(0.1, -0.15, 0.7), np.zeros(3)).evaluate(times)
    assert np.linalg.norm(v, axis=1) == pytest.approx(0.15)
    assert np.linalg.norm(p - p.mean(axis=0), axis=1) == pytest.approx(0.1)
    normal = np.array([0.0, -math.sin(0.7), math.cos(0.7)])
    assert np.abs(p @ normal).max() < 1e-12
    back = make_reference(circle(0.1, 0.15, 0.7), np.zeros(3)).evaluate(times)[0]
    assert back * [-1, 1, 1] == pytest.approx(p)


def test_names_are_files_and_unique():
    for stages in (STAGES, quick_stages()):
        names = [stage.name for stage in stages]
        assert len(set(names)) == len(names)
        assert not any(set(name) & set("/\\ ") for name in names)
        assert {stage.role for stage in stages} == {"training", "validation", "held_out"}


def test_training_is_as_the_paper_has_it():
    training = [stage for stage in STAGES if stage.role != "held_out"]
    assert {stage.duration_s for stage in training} == {150.0}
    assert all(stage.wind == Wind() and stage.payload == Payload() for stage in training)
    bases = [stage.base for stage in training]
    assert any(isinstance(base, Hover) for base in bases)
    radii = {base.amplitude_m[0] for base in bases if not isinstance(base, Hover)}
    assert radii == {0.10}
    assert len({stage.lap_s for stage in training}) >= 4


def test_nothing_held_out_was_trained_on():
    def motion(stage):
        return stage.lap_s, stage.tilt_rad, stage.base

    seen = {motion(stage) for stage in STAGES if stage.role != "held_out"}
    held_out = [stage for stage in STAGES if stage.role == "held_out"]
    assert not seen & {motion(stage) for stage in held_out}
    assert not {base for _, _, base in seen if base != Hover()} & {s.base for s in held_out}


def test_each_flight_is_held_out_in_calm_air_in_winds_and_with_a_payload():
    by_name = {stage.name: stage for stage in STAGES}
    held_out = [stage for stage in STAGES if stage.role == "held_out"]
    for stage in held_out:
        if stage.twin:
            twin = by_name[stage.twin]
            changes = {"name": twin.name, "twin": "", "seed": twin.seed}
            like = dataclasses.replace(stage, wind=Wind(), payload=Payload(), **changes)
            assert like == twin and (stage.wind != Wind()) != (stage.payload != Payload())
    winds = [stage.wind for stage in held_out if any(stage.wind.gust_m_s)]
    assert [np.linalg.norm(wind.velocity_m_s) for wind in winds] == pytest.approx([2.0] * 6)
    calm = held_out[0]
    assert [stage.name for stage in weathers(calm, 0.0, 1)[1:]] == [
        f"{calm.name}_{weather}" for weather in ("wind", "steady_wind", "payload")
    ]


def test_a_stage_flies_what_it_says_after_a_hover_that_is_not_recorded(scenario, vehicle):
    stage = Stage("x", "training", 4.0, 5.0, 0.5, circle(0.1, 0.1, 0.4))
    flown = fly_stage(scenario, stage)
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


def test_weather_is_the_stages_own(scenario):
    calm = Stage("x", "held_out", 1.0, 5.0, 0.0)
    stormy = dataclasses.replace(scenario, wind=Wind(velocity_m_s=(9.0, 0.0, 0.0)))
    assert np.array_equal(fly_stage(scenario, calm).state, fly_stage(stormy, calm).state)
    windy = dataclasses.replace(calm, wind=Wind(velocity_m_s=(2.0, 0.0, 0.0)))
    away = fly_stage(scenario, windy).state - fly_stage(scenario, calm).state
    assert (np.abs(away[:, 2]) > 0.01).all()  # Half the pitch that holds against the wind.

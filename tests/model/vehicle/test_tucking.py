"""Tucked arms: high enough, nearest, within limits, and repeatable."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from aerodrake.bench.arms import with_joints
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation
from aerodrake.model.vehicle.robot import BASE_FRAME, RobotDescription, add_robot
from aerodrake.model.vehicle.tucking import CLEARANCE_M, TOLERANCE_M, GroundGeometry, tuck
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.files import locate


def geometry_of(robot: str) -> GroundGeometry:
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, RobotDescription.read(robot))
    plant.Finalize()
    return GroundGeometry(plant, scene_graph, BASE_FRAME)


@pytest.fixture(scope="module")
def geometry(scenario) -> GroundGeometry:
    return geometry_of(scenario.vehicle.robot)


def test_feet_match_the_urdf(geometry, vehicle):
    """Spheres of 2 cm at z = -0.36 m."""
    assert geometry.feet == vehicle.feet_m == pytest.approx(-0.38)


def test_jacobian_of_the_heights(geometry, vehicle):
    q, step = vehicle.working + 0.1, 1e-6
    columns = [
        (geometry.heights(q + step * e) - geometry.heights(q - step * e)) / (2 * step)
        for e in np.eye(vehicle.joints)
    ]
    np.testing.assert_allclose(geometry.jacobian(q), np.column_stack(columns), atol=1e-8)


def test_heights_are_no_higher_than_the_collision_geometry(geometry, vehicle):
    """Compared with Drake's distance of the arm from the ground below the feet."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    add_robot(plant, vehicle.description)
    slab, pose = Box(100.0, 100.0, 1.0), RigidTransform([0.0, 0.0, -0.5])
    friction = CoulombFriction(1.0, 1.0)
    plant.RegisterCollisionGeometry(plant.world_body(), pose, slab, "slab", friction)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyContextFromRoot(context)
    query = scene_graph.get_query_output_port()
    (ground,) = plant.GetCollisionGeometriesForBody(plant.world_body())
    rng = np.random.default_rng(2)
    for q in (vehicle.working, vehicle.tucked, *(vehicle.working + rng.uniform(-1, 1, (20, 6)))):
        x = vehicle.trim_state[: plant.num_positions()]
        x[6], x[7:] = 2.0, q
        plant.SetPositions(plant_context, x)
        distances = [
            query.Eval(scene_graph.GetMyContextFromRoot(context))
            .ComputeSignedDistancePairClosestPoints(ground, geometry_id)
            .distance
            for body in map(
                plant.get_body, plant.GetBodyIndices(plant.GetModelInstanceByName("quadrotor_arm6"))
            )
            if body.name() != BASE_FRAME
            for geometry_id in plant.GetCollisionGeometriesForBody(body)
        ]
        lowest = geometry.heights(q).min()
        assert lowest <= min(distances) - 2.0 + 1e-6
        assert lowest > min(distances) - 2.0 - 0.03  # Corners of boxes around round shapes.


def test_the_packaged_vehicle(geometry, vehicle):
    assert geometry.heights(vehicle.tucked).min() >= vehicle.feet_m + CLEARANCE_M - TOLERANCE_M
    assert np.all((vehicle.tucked >= vehicle.lower) & (vehicle.tucked <= vehicle.upper))
    # It hardly moves, and the clearance constraint is active.
    assert np.abs(vehicle.tucked - vehicle.working).max() < 0.1
    assert geometry.heights(vehicle.tucked).min() == pytest.approx(
        vehicle.feet_m + CLEARANCE_M, abs=1e-5
    )


def test_the_tucked_configuration_can_be_flown(scenario, vehicle):
    """Loading it as the working configuration checks torques, trim and ground."""
    changed = replace(scenario.vehicle, working_rad=tuple(vehicle.tucked))
    tucked = VehicleModel.load(replace(scenario, vehicle=changed))
    assert np.all(np.abs(tucked.trim_torque) < vehicle.effort / 2)
    ThrustAllocation.make(tucked, scenario.vehicle.rotor)


@pytest.mark.parametrize("joints", [2, 3, 4, 5, 7, 8, 9])
def test_other_arms(tmp_path, joints):
    changed = with_joints(Scenario(), joints, tmp_path / "arm.urdf")
    other = VehicleModel.load(changed)
    geometry = geometry_of(other.robot)
    assert other.tucked.shape == (joints,)
    assert geometry.heights(other.tucked).min() >= other.feet_m + CLEARANCE_M - TOLERANCE_M
    np.testing.assert_array_equal(other.tucked, VehicleModel.load(changed).tucked)


@settings(max_examples=20)
@given(st.integers(0, 2**32))
def test_from_any_configuration_high_enough_or_as_high_as_possible(scenario, vehicle, seed):
    """The hardest start is the arm hanging down."""
    geometry = geometry_of(scenario.vehicle.robot)
    share = np.random.default_rng(seed).uniform(size=vehicle.joints)
    working = vehicle.lower + share * (vehicle.upper - vehicle.lower)
    q = tuck(geometry, working)
    assert np.all((q >= vehicle.lower) & (q <= vehicle.upper))
    assert geometry.heights(q).min() >= geometry.feet + CLEARANCE_M - TOLERANCE_M
    if geometry.heights(working).min() >= geometry.feet + CLEARANCE_M:
        np.testing.assert_allclose(q, working, atol=1e-6)


def test_an_arm_that_cannot_be_high_enough_is_as_high_as_possible(tmp_path):
    """A single yaw joint cannot lift the arm."""
    other = VehicleModel.load(with_joints(Scenario(), 1, tmp_path / "arm.urdf"))
    geometry = geometry_of(other.robot)
    highest = max(geometry.heights(np.array([q])).min() for q in np.linspace(-3, 3, 601))
    lowest_corner = geometry.heights(other.tucked).min()
    assert lowest_corner < other.feet_m + CLEARANCE_M
    assert lowest_corner == pytest.approx(highest, abs=1e-4)


def test_an_arm_without_collision_geometry_stays(tmp_path, scenario, vehicle):
    text = Path(locate(scenario.vehicle.robot)).read_text()
    text = re.sub(r"<collision>.*?</collision>", "", text, flags=re.DOTALL)
    robot = tmp_path / "robot.urdf"
    robot.write_text(text)
    other = VehicleModel.load(
        replace(scenario, vehicle=replace(scenario.vehicle, robot=str(robot)))
    )
    assert other.feet_m == 0
    np.testing.assert_array_equal(other.tucked, other.working)

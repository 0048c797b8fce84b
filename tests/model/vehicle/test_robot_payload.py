"""Payload in a plant: weight, inertia and position; nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from aerodrake.model.vehicle.robot import (
    PAYLOAD_BODY,
    STEEL_KG_M3,
    TOOL_FRAME,
    add_payload,
    add_robot,
    add_visible_payload,
)
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Payload
from tests.robots import at, make_plant
from tests.trim import assert_same_vehicle

MASS = 0.2


@pytest.fixture(scope="module")
def bare(vehicle, scene_graph):
    return make_plant(vehicle.robot, scene_graph)


@pytest.fixture(scope="module")
def loaded(vehicle, scene_graph):
    return make_plant(vehicle.robot, scene_graph, payload_kg=MASS)


def tool_jacobian(plant, state) -> np.ndarray:
    """Returns the tool's Jacobian (6, 6 + n) in the world, rotation first."""
    world = plant.world_frame()
    return plant.CalcJacobianSpatialVelocity(
        at(plant, state),
        JacobianWrtVariable.kV,
        plant.GetFrameByName(TOOL_FRAME),
        np.zeros(3),
        world,
        world,
    )


def test_no_mass_is_no_payload(vehicle, bare):
    plain = MultibodyPlant(0.001)
    add_robot(plain, vehicle.description)
    plain.Finalize()
    assert bare.num_bodies() == plain.num_bodies()
    assert bare.num_model_instances() == plain.num_model_instances()
    assert not bare.HasBodyNamed(PAYLOAD_BODY)


def test_it_adds_its_mass(bare, loaded, bent_state):
    total = [plant.CalcTotalMass(at(plant, bent_state)) for plant in (bare, loaded)]
    np.testing.assert_allclose(total, [3.8, 3.8 + MASS])


def test_it_adds_its_weight_at_the_tool(bare, loaded, bent_state):
    added = [plant.CalcGravityGeneralizedForces(at(plant, bent_state)) for plant in (bare, loaded)]
    J_v = tool_jacobian(bare, bent_state)[3:]
    np.testing.assert_allclose(added[1] - added[0], J_v.T @ [0, 0, -MASS * 9.81], atol=1e-12)


def test_it_adds_the_inertia_of_a_steel_ball_at_the_tool(bare, loaded, bent_state):
    added = [plant.CalcMassMatrix(at(plant, bent_state)) for plant in (bare, loaded)]
    J_w, J_v = np.split(tool_jacobian(bare, bent_state), 2)
    squared_radius = (MASS / STEEL_KG_M3 / (4 / 3 * np.pi)) ** (2 / 3)
    assert squared_radius == pytest.approx(0.018**2, rel=0.05)  # 18 mm: nearly a point.
    expected = MASS * J_v.T @ J_v + 0.4 * MASS * squared_radius * J_w.T @ J_w
    np.testing.assert_allclose(added[1] - added[0], expected, atol=1e-14)


def test_order_of_states_bodies_and_actuators_is_unchanged(bare, loaded):
    assert loaded.GetStateNames() == bare.GetStateNames()
    assert loaded.GetActuatorNames() == bare.GetActuatorNames()
    assert loaded.num_bodies() == bare.num_bodies() + 1
    payload = loaded.GetBodyByName(PAYLOAD_BODY)
    assert int(payload.index()) == bare.num_bodies()
    for name in ("base", "gripper"):
        assert loaded.GetBodyByName(name).index() == bare.GetBodyByName(name).index()


def test_it_has_no_geometry_unless_it_is_drawn(vehicle, scene_graph, bare, loaded):
    drawn = MultibodyPlant(0.0)
    drawn.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(drawn, vehicle.description)
    add_visible_payload(drawn, MASS)
    drawn.Finalize()
    for plant, count in ((drawn, 1), (loaded, 0)):
        payload = plant.GetBodyByName(PAYLOAD_BODY)
        assert len(plant.GetVisualGeometriesForBody(payload)) == count
        assert not plant.GetCollisionGeometriesForBody(payload)
    assert loaded.num_collision_geometries() == bare.num_collision_geometries()


def test_a_plant_without_scene_graph_has_it(vehicle):
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    add_payload(plant, MASS)
    plant.Finalize()
    assert plant.GetBodyByName(PAYLOAD_BODY).default_mass() == MASS


def test_the_vehicle_model_has_no_payload(scenario, vehicle):
    loaded = VehicleModel.load(replace(scenario, payload=Payload(mass_kg=MASS)))
    assert_same_vehicle(loaded, vehicle)

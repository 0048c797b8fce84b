"""Wiring of the plant: rigid bodies, their contact geometry, and propellers."""

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import System

from aerodrake.model.vehicle.robot import (
    BASE_FRAME,
    add_ground,
    add_payload,
    add_robot,
    make_scene_graph,
)
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.support.errors import ScenarioError, file_at
from aerodrake.systems.rotors import make_propellers
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs

WIRING = Wiring(
    connections=(
        ("propellers", "spatial_forces", "multibody_plant", "applied_spatial_force"),
        ("multibody_plant", "body_poses", "propellers", "body_poses"),
    ),
    inputs=(
        ("thrust", "propellers", "command"),
        ("joint_torque", "multibody_plant", "actuation"),
        ("generalized_force", "multibody_plant", "applied_generalized_force"),
    ),
    outputs=outputs("multibody_plant", "state", "body_poses"),
)
CONTACT = Wiring(
    connections=(
        ("multibody_plant", "geometry_pose", "scene_graph", "multibody_plant_pose"),
        ("scene_graph", "query", "multibody_plant", "geometry_query"),
    ),
)


@checked
def make_plant(
    scenario: Scenario, vehicle: VehicleModel, replacements: Replacements | None = None
) -> System:
    """Makes the plant of the scenario's vehicle, payload and mismatch, in trim by default.

    With `physics.engine` drake it is a diagram of `multibody_plant`, `propellers` and a
    `scene_graph`, which has collision geometry alone, since nothing is drawn from it, and is absent
    if the robot has none. With mujoco it is a `MujocoPlant`. A system with these ports can replace
    it, by the name `plant`.

    Inputs: `thrust` (k) N, as it acts; `joint_torque` (n) N m, which Drake, but not MuJoCo, limits
    by the joints' effort limits; `generalized_force` (6 + n) on the velocities [omega_W, v_B, q'].
    Outputs: `state` (13 + 2 n), a `VehicleState`; `body_poses` (abstract, optional), a list of
    the poses (`RigidTransform`) in the world of the bodies in the order of `vehicle.plant`: the
    world's first, then those of the robot's links, and a payload's last.

    Args:
        scenario: Engine, payload, mismatch and rotors; its `rates.plant_step_s` is the discrete
            step.
        vehicle: The scenario's vehicle.
        replacements: Replacements of its systems; None for none.

    Raises:
        BadInput: if Drake cannot parse the robot, a replacement does not fit, or MuJoCo is not
            installed.
    """
    plant, scene_graph = _make_bodies(scenario, vehicle)
    if scenario.physics.engine == "mujoco":
        return _make_mujoco_plant(scenario, vehicle, plant, scene_graph)
    builder, wiring = (replacements or Replacements()).builder(), WIRING
    base = plant.GetBodyByName(BASE_FRAME).index()
    builder.AddSystem(plant)
    if scene_graph is not None:
        builder.AddNamedSystem("scene_graph", scene_graph)
        wiring += CONTACT
    builder.AddNamedSystem(
        "propellers", make_propellers(scenario.vehicle.rotor, vehicle.rotors, base)
    )
    return wiring.build(builder, "plant")


def _make_bodies(
    scenario: Scenario, vehicle: VehicleModel
) -> tuple[MultibodyPlant, SceneGraph | None]:
    """Makes a finalised plant of vehicle, payload and ground, and the SceneGraph of their collision
    geometry; None if the robot has none."""
    plant = MultibodyPlant(scenario.rates.plant_step_s)
    plant.set_name("multibody_plant")  # A SceneGraph names its port after it.
    scene_graph = make_scene_graph() if vehicle.description.has_collision_geometry else None
    if scene_graph is not None:
        plant.RegisterAsSourceForSceneGraph(scene_graph)
    with file_at(scenario.source, "vehicle.robot"):
        add_robot(plant, vehicle.description, scenario.mismatch)
    add_payload(plant, scenario.payload.mass_kg)
    if scene_graph is not None:
        add_ground(plant)
    plant.SetUseSampledOutputPorts(False)  # True would make a step an unrestricted update.
    plant.Finalize()
    plant.SetDefaultPositions(vehicle.trim_state[: plant.num_positions()])
    return plant, scene_graph


def _make_mujoco_plant(
    scenario: Scenario,
    vehicle: VehicleModel,
    plant: MultibodyPlant,
    scene_graph: SceneGraph | None,
) -> System:
    """Makes the plant in MuJoCo from that in Drake.

    Raises:
        ScenarioError: if MuJoCo is not installed.
    """
    try:
        from aerodrake.model.mujoco.engine import MujocoEngine
        from aerodrake.model.mujoco.model import body_numbers, make_mujoco_model
        from aerodrake.systems.mujoco_plant import MujocoPlant
    except ImportError:
        expected = "mujoco expects the extra [mujoco]: pip install 'aerodrake[mujoco]'"
        raise ScenarioError(scenario.source, "physics.engine", expected) from None
    physics, period = scenario.physics, scenario.rates.plant_step_s
    ratio = scenario.vehicle.rotor.torque_ratio_m
    model = make_mujoco_model(plant, scene_graph, vehicle.rotors, ratio)
    engine = MujocoEngine(model, period, physics.integrator, physics.substeps)
    system = MujocoPlant(engine, body_numbers(model, plant), vehicle.trim_state, period)
    system.set_name("plant")
    return system

"""Plant, scene graph, rotors and propellers, connected."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
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
from aerodrake.support.errors import file_at
from aerodrake.systems.faults.actuators import make_rotor_faults
from aerodrake.systems.rotors import make_propellers, make_rotors
from aerodrake.wiring.table import Wiring

WIRING = Wiring(
    connections=(
        ("rotors", "y0", "propellers", "command"),
        ("propellers", "spatial_forces", "plant", "applied_spatial_force"),
        ("plant", "body_poses", "propellers", "body_poses"),
        ("plant", "geometry_pose", "scene_graph", "plant_pose"),
        ("scene_graph", "query", "plant", "geometry_query"),
    ),
    outputs=(
        ("rotors", "y0", "thrust"),
        ("plant", "state", "true_state"),
        ("scene_graph", "query", "query_object"),
    ),
)


@checked
def add_physics(
    builder: DiagramBuilder, scenario: Scenario, vehicle: VehicleModel
) -> tuple[np.ndarray, Wiring]:
    """Adds the scenario's plant, with its payload and mismatch, in trim by default.

    Returns:
        (k,) N, thrusts in trim; connections and outputs of the added systems. Inputs left to
        connect: `u0` of `rotors`, the commanded thrusts; `actuation` and
        `applied_generalized_force` of `plant`.
    """
    step, rotor = scenario.rates.plant_step_s, scenario.vehicle.rotor
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    scene_graph = builder.AddNamedSystem("scene_graph", make_scene_graph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    with file_at(scenario.source, "vehicle.robot"):
        add_robot(plant, vehicle.description, scenario.mismatch)
    add_payload(plant, scenario.payload.mass_kg)
    add_ground(plant)
    plant.SetUseSampledOutputPorts(False)  # True would make a step an unrestricted update.
    plant.Finalize()
    plant.SetDefaultPositions(vehicle.trim_state[: plant.num_positions()])
    trim = allocate(ThrustAllocation.make(vehicle, rotor), vehicle.trim_wrench)
    builder.AddNamedSystem("rotors", make_rotors(rotor, scenario.mismatch, trim, step))
    base = plant.GetBodyByName(BASE_FRAME).index()
    builder.AddNamedSystem("propellers", make_propellers(rotor, vehicle.rotors, base))
    wiring = WIRING
    if (rotor_faults := make_rotor_faults(scenario, len(trim))) is not None:
        builder.AddNamedSystem("rotor_faults", rotor_faults)
        wiring = wiring.insert("rotor_faults", ("rotors", "y0"))
    return trim, wiring

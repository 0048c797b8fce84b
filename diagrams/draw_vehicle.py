"""Renders the vehicle on the clover for the README."""

from pathlib import Path

import numpy as np
from matplotlib import image
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

import aerodrake
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.vehicle.robot import add_robot
from aerodrake.model.vehicle.vehicle import VehicleModel

EYE, TARGET = np.array([0.75, 1.35, 1.75]), np.array([-0.22, 0.12, 1.33])
WIDTH, HEIGHT = 1200, 640


def main() -> None:
    scenario = aerodrake.load_scenario("clover")
    vehicle = VehicleModel.load(scenario)
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    add_robot(plant, vehicle.description)
    lap = make_reference(scenario.reference, vehicle.p_E).evaluate(np.linspace(3, 27, 700))[0]
    for i, point in enumerate(lap):
        pose, color = RigidTransform(point), np.array([0.91, 0.35, 0.05, 1.0])
        plant.RegisterVisualGeometry(plant.world_body(), pose, Sphere(0.004), f"lap{i}", color)
    plant.Finalize()
    params = RenderEngineVtkParams(default_clear_color=[1.0, 1.0, 1.0])
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(params))
    diagram = builder.Build()

    context = diagram.CreateDefaultContext()
    positions = vehicle.trim_state[: plant.num_positions()]
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), positions)
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    look = RotationMatrix(np.column_stack([right, np.cross(forward, right), forward]))
    camera = ColorRenderCamera(
        RenderCameraCore(
            "vtk", CameraInfo(WIDTH, HEIGHT, 0.7), ClippingRange(0.1, 20.0), RigidTransform()
        )
    )
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    picture = query.RenderColorImage(
        camera, scene_graph.world_frame_id(), RigidTransform(look, EYE)
    )
    path = Path(__file__).parent / "vehicle.png"
    image.imsave(path, picture.data[:, :, :3], metadata={"Software": None})
    print(path)


if __name__ == "__main__":
    main()

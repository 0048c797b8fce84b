"""The vehicle and its paths in Meshcat."""

import gc
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

import numpy as np
from pydrake.geometry import (
    Box,
    Meshcat,
    MeshcatParams,
    MeshcatVisualizer,
    QueryObject,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.perception import PointCloud
from pydrake.systems.framework import DiagramBuilder

from aerodrake.model.vehicle.drake_log import plain, recorded_log, warn_once
from aerodrake.model.vehicle.robot import (
    BASE_FRAME,
    add_ground,
    add_visible_payload,
    add_visible_robot,
    make_scene_graph,
)
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario

VIEW_FROM_M = np.array([0.85, 1.3, 0.3])
"""(3,) in the world, from the point that the camera looks at to the camera."""
DOT_SPACING_M = 0.02
DOT_SIZE_M = 0.008
MOST_DOTS = 20_000
REFERENCE_COLOR = Rgba(0.12, 0.16, 0.2, 1.0)
TRACE_COLOR = Rgba(0.91, 0.35, 0.05, 1.0)
PREDICTION_COLOR = Rgba(0.09, 0.39, 0.67, 1.0)
SPACE = "/learning_space"
SPACE_COLOR = Rgba(0.17, 0.54, 0.24, 0.25)


class Scene:
    """A scenario's vehicle, with its payload, on the ground.

    It is a context manager, since Meshcat ends the process if it is garbage collected in another
    thread than its own.

    Attributes:
        meshcat: Meshcat server of the scene.

    Args:
        scenario: The scenario of the flight.
        vehicle: Its vehicle.
    """

    def __init__(self, scenario: Scenario, vehicle: VehicleModel):
        self.meshcat = _silent_meshcat()
        self.meshcat.SetProperty("/Axes", "visible", False)
        self._robot = Path(vehicle.robot).name
        self._p_O = vehicle.p_O
        self._size_m = scenario.allocation.learning_space_m
        builder = DiagramBuilder()
        self._plant, scene_graph = _add_vehicle(builder, scenario, vehicle)
        MeshcatVisualizer.AddToBuilder(builder, scene_graph, self.meshcat)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        del self.meshcat, self._plant, self._diagram, self._context
        gc.collect()

    def pose(self, time_s: float, positions: np.ndarray) -> None:
        """Sets the time and the positions (7 + n,): quaternion, p_B in m, q in rad."""
        self._context.SetTime(time_s)
        self._plant.SetPositions(self._plant.GetMyMutableContextFromRoot(self._context), positions)
        with recorded_log() as warnings:
            self._diagram.ForcedPublish(self._context)
        for warning in map(plain, warnings):
            warn_once(f"{self._robot}: {warning}")

    def draw_reference(self, points: np.ndarray) -> None:
        """Draws dots along points (K, 3) m in the world, which stay visible under a trace."""
        if not len(points):
            return
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        spacing = max(DOT_SPACING_M, along[-1] / MOST_DOTS)
        dots = np.searchsorted(along, np.arange(0.0, along[-1] + 1e-9, spacing))
        dots = np.minimum(dots, len(points) - 1)  # The last may exceed it by rounding.
        cloud = PointCloud(len(dots))
        cloud.mutable_xyzs()[:] = points[dots].T
        self.meshcat.SetObject(
            "/paths/reference", cloud, point_size=DOT_SIZE_M, rgba=REFERENCE_COLOR
        )

    def draw_trace(self, points: np.ndarray) -> None:
        """Draws the path of the end-effector, points (K, 3) m in the world."""
        self.meshcat.SetLine("/paths/end_effector", points.T, line_width=3.0, rgba=TRACE_COLOR)

    def draw_prediction(self, points: np.ndarray) -> None:
        """Draws p_E over the horizon, points (N + 1, 3) m in the world."""
        self.meshcat.SetLine("/paths/prediction", points.T, line_width=4.0, rgba=PREDICTION_COLOR)

    def draw_learning_space(self) -> None:
        """Draws its box at the current pose of the base."""
        if not self.meshcat.HasPath(SPACE):
            self.meshcat.SetObject(SPACE, Box(*self._size_m), SPACE_COLOR)
        base = self._plant.GetBodyByName(BASE_FRAME)
        plant_context = self._plant.GetMyContextFromRoot(self._context)
        X_WB = self._plant.EvalBodyPoseInWorld(plant_context, base)
        self.meshcat.SetTransform(SPACE, X_WB @ RigidTransform(self._p_O))

    def look_at(self, middle: np.ndarray) -> None:
        """Turns the camera to a point, middle (3,) m in the world."""
        self.meshcat.SetCameraPose(middle + VIEW_FROM_M, middle)


@contextmanager
def posed_scene(
    scenario: Scenario, vehicle: VehicleModel, positions: np.ndarray
) -> Iterator[QueryObject]:
    """Yields the geometry of a scenario's vehicle at positions (7 + n,), without a visualizer."""
    builder = DiagramBuilder()
    plant, scene_graph = _add_vehicle(builder, scenario, vehicle)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), positions)
    own = scene_graph.GetMyContextFromRoot(context)
    yield scene_graph.get_query_output_port().Eval(own)


def _add_vehicle(
    builder: DiagramBuilder, scenario: Scenario, vehicle: VehicleModel
) -> tuple[MultibodyPlant, SceneGraph]:
    """Adds the plant of a vehicle, with its payload and the ground, and its geometry."""
    plant = builder.AddSystem(MultibodyPlant(0.0))
    scene_graph = builder.AddSystem(make_scene_graph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_visible_robot(plant, vehicle.description)
    add_visible_payload(plant, scenario.payload.mass_kg)
    add_ground(plant)
    plant.Finalize()
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    return plant, scene_graph


def _silent_meshcat() -> Meshcat:
    """Returns a server that does not print its address."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    finally:
        logger.setLevel(level)

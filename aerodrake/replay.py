"""The flight as a recording that plays in a browser, offline."""

from __future__ import annotations

import logging

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, Rgba, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.perception import PointCloud
from pydrake.systems.framework import DiagramBuilder

from aerodrake.flight_log import FlightLog
from aerodrake.model.payload import add_payload
from aerodrake.model.vehicle import add_ground, add_robot
from aerodrake.scenario import Scenario

FRAMES_PER_S = 30.0
MOST_FRAMES = 1800
"""Longer recordings have fewer frames a second, lest pages grow with the flight."""
MOST_POINTS = 6000
"""Of a path likewise."""
VIEW_FROM_M = np.array([0.85, 1.3, 0.3])
DOT_SPACING_M = 0.02
DOT_SIZE_M = 0.008
REFERENCE_COLOR = Rgba(0.12, 0.16, 0.2, 1.0)
TRACE_COLOR = Rgba(0.91, 0.35, 0.05, 1.0)


def replay_page(log: FlightLog, scenario: Scenario) -> str:
    """A self-contained HTML page: the vehicle, its reference and its trace.

    Args:
        log: The flight; its animation begins at reference time 0, or where
            the flight ended if that was before.
        scenario: Whose robot flew, with its payload.
    """
    meshcat = _silent_meshcat()
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    scene_graph = builder.AddSystem(SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, scenario.vehicle.robot)
    add_payload(plant, scenario.payload.mass_kg)
    add_ground(plant)
    plant.Finalize()
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)

    time_s, parts = log.time_s, ("quaternion", "p_B_m", "q_rad")
    finite = np.all([np.isfinite(log[part]).all(axis=1) for part in parts], axis=0)
    end = time_s[finite][-1]
    flown = np.flatnonzero(finite & (time_s >= min(0.0, end)))
    stride = -(-len(flown) // MOST_POINTS)
    shown = flown[(len(flown) - 1) % stride :: stride]
    meshcat.SetProperty("/Axes", "visible", False)
    _draw_reference(meshcat, log["p_Ed_m"][shown])
    meshcat.SetLine("/paths/end_effector", log["p_E_m"][shown].T, line_width=3.0, rgba=TRACE_COLOR)
    middle = log["p_B_m"][flown].mean(axis=0)
    meshcat.SetCameraPose(middle + VIEW_FROM_M, middle)

    pace = min(FRAMES_PER_S, MOST_FRAMES / max(end, 1.0))
    times = np.arange(0.0, max(end, 0.0) + 1e-9, 1 / pace)
    rows = flown[np.minimum(np.searchsorted(time_s[flown], times - 1e-9), len(flown) - 1)]
    positions = np.hstack([log[part][rows] for part in parts])
    meshcat.StartRecording(frames_per_second=pace)
    for time, position in zip(times, positions, strict=True):
        context.SetTime(time)
        plant.SetPositions(plant_context, position)
        diagram.ForcedPublish(context)
    meshcat.StopRecording()
    meshcat.PublishRecording()
    return meshcat.StaticHtml()


def _silent_meshcat() -> Meshcat:
    """A server that nobody asked for, and so does not say where it listens."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    finally:
        logger.setLevel(level)


def _draw_reference(meshcat: Meshcat, points: np.ndarray) -> None:
    """Dots along the path, which a trace on top of them leaves visible."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    dots = np.searchsorted(along, np.arange(0.0, along[-1] + 1e-9, DOT_SPACING_M))
    dots = np.minimum(dots, len(points) - 1)  # The last may be beyond by rounding.
    cloud = PointCloud(len(dots))
    cloud.mutable_xyzs()[:] = points[dots].T
    meshcat.SetObject("/paths/reference", cloud, point_size=DOT_SIZE_M, rgba=REFERENCE_COLOR)

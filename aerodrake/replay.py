"""The flight as a recording that plays in a browser, offline."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, Rgba, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from aerodrake.flight_log import FlightLog
from aerodrake.model.vehicle import add_ground, add_robot

FRAMES_PER_S = 30.0
VIEW_FROM_M = np.array([1.1, 1.7, 0.3])
REFERENCE_COLOR = Rgba(0.53, 0.56, 0.59, 1.0)
TRACE_COLOR = Rgba(0.91, 0.35, 0.05, 1.0)


def write_replay(log: FlightLog, robot: str, path: Path) -> None:
    """Writes a self-contained HTML page: the vehicle, its reference and its trace.

    Args:
        log: The flight; its animation begins at reference time 0.
        robot: The URI or path of the URDF it flew.
        path: Of the page.
    """
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    scene_graph = builder.AddSystem(SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, robot)
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

    flown = np.flatnonzero(log.time_s >= 0)
    _draw_path(meshcat, "reference", log["p_Ed_m"][flown], REFERENCE_COLOR, 2.0)
    _draw_path(meshcat, "end_effector", log["p_E_m"][flown], TRACE_COLOR, 3.0)
    middle = log["p_B_m"][flown].mean(axis=0)
    meshcat.SetCameraPose(middle + VIEW_FROM_M, middle)

    meshcat.StartRecording(frames_per_second=FRAMES_PER_S)
    positions = np.hstack([log["quaternion"], log["p_B_m"], log["q_rad"]])
    for time in np.arange(0.0, log.time_s[-1] + 1e-9, 1 / FRAMES_PER_S):
        i = flown[0] + np.searchsorted(log.time_s[flown], time - 1e-9)
        context.SetTime(time)
        plant.SetPositions(plant_context, positions[min(i, len(positions) - 1)])
        diagram.ForcedPublish(context)
    meshcat.StopRecording()
    meshcat.PublishRecording()
    path.write_text(meshcat.StaticHtml(), encoding="utf-8")


def _draw_path(meshcat: Meshcat, name: str, points: np.ndarray, color: Rgba, width: float) -> None:
    meshcat.SetLine(f"/paths/{name}", points.T, line_width=width, rgba=color)

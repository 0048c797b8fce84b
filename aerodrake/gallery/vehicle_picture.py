"""Picture of a scenario's vehicle at the start, with marks at places of the world."""

from collections.abc import Iterator
from itertools import combinations, product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from aerodrake.gallery.camera import Camera
from aerodrake.model.vehicle.robot import TOOL_FRAME, add_visible_robot
from aerodrake.model.vehicle.vehicle import VehicleModel

SHARPER = 2
"""Number of pixels that are rendered for each of the picture, along each axis."""

BACKGROUND, ORANGE = (0.93, 0.945, 0.96), (0.91, 0.35, 0.05, 1.0)
LIGHTS = (((-0.4, -0.7, -1.0), 0.9), ((0.6, -0.9, 0.5), 0.6), ((0.0, 0.3, -1.0), 0.3))
"""Direction in the world and intensity of each light: from the camera's side, below and above."""

INK, TEXT, DPI = "#1f2933", 19, 100
AXIS_COLORS, AXIS_M = ("#e03131", "#2f9e44", "#1c7ed6"), 0.14
"""Colours and length of the axes x, y, z of a frame."""


class VehiclePicture:
    """A figure with the rendered vehicle in trim, to draw marks on.

    Attributes:
        figure: The figure.
        frames: Pose in the world of the tool's frame, `TOOL_FRAME`, and of each joint by name.

    Args:
        vehicle: The vehicle.
        path: (K, 3) m, points in the world that are drawn as small spheres.
        camera: The camera.
    """

    def __init__(self, vehicle: VehicleModel, path: np.ndarray, camera: Camera):
        self._camera = camera
        self.figure = Figure(figsize=(camera.width / DPI, camera.height / DPI), dpi=DPI)
        self._axes: Axes = self.figure.add_axes((0, 0, 1, 1))
        pixels, self.frames = _render(vehicle, path, camera)
        self._axes.imshow(pixels, extent=(0, camera.width, camera.height, 0))
        self._axes.set_axis_off()

    def _pixel(self, point: np.ndarray) -> np.ndarray:
        return self._camera.project(point)[0]

    def name(self, text: str, point: np.ndarray, place: tuple[float, float], **style: Any) -> None:
        """Writes a text at a place of the picture, with a line to a point of the world.

        Args:
            text: The text.
            point: (3,) m.
            place: Of the left end of the text, in pixels.
            style: `color` of both, and `start`, the part of the text where the line begins.
        """
        color, start = style.get("color", INK), style.get("start", (0.5, 0.5))
        line = {"arrowstyle": "-", "color": color, "linewidth": 1.4, "shrinkB": 0, "relpos": start}
        end, look = self._pixel(point), {"fontsize": TEXT, "color": color, "va": "center"}
        self._axes.annotate(text, end, place, arrowprops=line, **look)
        self._axes.plot(*end, marker="o", color=color, markersize=6, markeredgecolor="white")

    def write(self, text: str, point: np.ndarray, beside: tuple[float, float]) -> None:
        """Writes a text at a distance in pixels from a point (3,) of the world."""
        place = self._pixel(point) + beside
        self._axes.text(*place, text, fontsize=TEXT, ha="center", color=INK)

    def frame(self, pose: RigidTransform) -> None:
        """Draws the axes of a frame, x red, y green, z blue."""
        start = self._pixel(pose.translation())
        for axis, color, direction in zip(
            "xyz", AXIS_COLORS, pose.rotation().matrix().T, strict=True
        ):
            end = self._pixel(pose.translation() + AXIS_M * direction)
            arrow = {
                "arrowstyle": "-|>",
                "color": color,
                "linewidth": 3,
                "shrinkA": 0,
                "shrinkB": 0,
            }
            self._axes.annotate("", end, start, arrowprops=arrow)
            self._axes.annotate(
                axis, end, end + 0.16 * (end - start), color=color, fontsize=TEXT - 3
            )

    def box(self, centre: np.ndarray, size: np.ndarray, color: str) -> None:
        """Draws the edges of a box, parallel to the world's axes; centre and size (3,) in m."""
        for low, high in _edges():
            ends = [self._pixel(centre + corner * size) for corner in (low, high)]
            self._axes.plot(*np.transpose(ends), color=color, linewidth=2)


def _edges() -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yields the ends of the twelve edges of a cube of size 1 around the origin."""
    corners = [np.array(signs) for signs in product((-0.5, 0.5), repeat=3)]
    for low, high in combinations(corners, 2):
        if np.count_nonzero(low != high) == 1:
            yield low, high


def _render(
    vehicle: VehicleModel, path: np.ndarray, camera: Camera
) -> tuple[np.ndarray, dict[str, RigidTransform]]:
    """Returns the pixels, (rows, columns, 3), and the poses of the tool and of each joint."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    add_visible_robot(plant, vehicle.description)
    for i, point in enumerate(path):
        pose, color = RigidTransform(point), np.array(ORANGE)
        plant.RegisterVisualGeometry(plant.world_body(), pose, Sphere(0.004), f"path{i}", color)
    plant.Finalize()
    lights = [
        LightParameter(type="directional", frame="world", direction=direction, intensity=intensity)
        for direction, intensity in LIGHTS
    ]
    params = RenderEngineVtkParams(default_clear_color=BACKGROUND, lights=lights)
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(params))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.SetPositions(own, vehicle.trim_state[: plant.num_positions()])
    info = CameraInfo(SHARPER * camera.width, SHARPER * camera.height, camera.view_rad)
    core = RenderCameraCore("vtk", info, ClippingRange(0.1, 20.0), RigidTransform())
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    world, lens = scene_graph.world_frame_id(), ColorRenderCamera(core)
    pixels = query.RenderColorImage(lens, world, camera.pose).data[:, :, :3].copy()
    frames = {TOOL_FRAME: plant.GetFrameByName(TOOL_FRAME)}
    frames |= {name: plant.GetJointByName(name).frame_on_child() for name in vehicle.joint_names}
    return pixels, {name: frame.CalcPoseInWorld(own) for name, frame in frames.items()}

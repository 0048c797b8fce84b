"""Renders the vehicle at the start of the clover, with the names of its parts, for the README."""

from collections.abc import Iterator, Mapping
from itertools import combinations, product
from pathlib import Path

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
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from aerodrake.model.reference.curves import make_reference
from aerodrake.model.vehicle.robot import TOOL_FRAME, add_robot
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario

EYE, TARGET = np.array([0.80, 1.45, 1.72]), np.array([-0.12, 0.12, 1.335])
WIDTH, HEIGHT, VIEW_RAD = 1600, 860, 0.56
"""Size of the picture in pixels, and its vertical angle of view."""
SHARPER = 2
"""Pixels that are rendered for each of the picture, along each axis."""

LIGHTS = (((-0.4, -0.7, -1.0), 0.9), ((0.6, -0.9, 0.5), 0.6), ((0.0, 0.3, -1.0), 0.3))
"""Direction in the world and intensity of each light: key, fill from below, and from above."""

AXIS_COLORS, AXIS_M = ("#e03131", "#2f9e44", "#1c7ed6"), 0.14
"""Colours and length of the axes x, y, z of a frame."""

ROTOR_NAMES = ((-215, 92), (0, -32), (60, -32), (0, -32))
"""Distance of each rotor's name from its hub, in pixels."""

AHEAD = 390
"""Point of the lap to which the reference's name belongs."""

BLUE, INK, TEXT = "#1864ab", "#1f2933", 19
"""Colours of the learning space and of texts, and size of texts: 10 pixels on a width of 600."""


def main() -> None:
    scenario = load_scenario("clover")
    vehicle = VehicleModel.load(scenario)
    picture, frames = render(scenario, vehicle)
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.imshow(picture, extent=(0, WIDTH, HEIGHT, 0), interpolation="antialiased")
    axes.set_axis_off()
    label(axes, scenario, vehicle, frames)
    path = Path(__file__).parent / "vehicle.png"
    figure.savefig(path, metadata={"Software": None})
    print(path)


def render(
    scenario: Scenario, vehicle: VehicleModel
) -> tuple[np.ndarray, Mapping[str, RigidTransform]]:
    """Returns the picture, (rows, columns, 3), and the poses of tool and joints in the world."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    add_robot(plant, vehicle.description)
    for i, point in enumerate(lap(scenario, vehicle)):
        pose, color = RigidTransform(point), np.array([0.91, 0.35, 0.05, 1.0])
        plant.RegisterVisualGeometry(plant.world_body(), pose, Sphere(0.004), f"lap{i}", color)
    plant.Finalize()
    lights = [
        LightParameter(type="directional", frame="world", direction=direction, intensity=intensity)
        for direction, intensity in LIGHTS
    ]
    params = RenderEngineVtkParams(default_clear_color=[0.93, 0.945, 0.96], lights=lights)
    scene_graph.AddRenderer("vtk", MakeRenderEngineVtk(params))
    diagram = builder.Build()

    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.SetPositions(own, vehicle.trim_state[: plant.num_positions()])
    info = CameraInfo(SHARPER * WIDTH, SHARPER * HEIGHT, VIEW_RAD)
    core = RenderCameraCore("vtk", info, ClippingRange(0.1, 20.0), RigidTransform())
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    picture = query.RenderColorImage(
        ColorRenderCamera(core), scene_graph.world_frame_id(), RigidTransform(look(), EYE)
    )
    frames = {TOOL_FRAME: plant.GetFrameByName(TOOL_FRAME).CalcPoseInWorld(own)}
    for name in vehicle.joint_names:
        frames[name] = plant.GetJointByName(name).frame_on_child().CalcPoseInWorld(own)
    return picture.data[:, :, :3].copy(), frames


def lap(scenario: Scenario, vehicle: VehicleModel) -> np.ndarray:
    """Returns points (900, 3) of the first lap after the smooth start."""
    times = scenario.reference.start_s + np.linspace(0, scenario.reference.lap_s, 900)
    return make_reference(scenario.reference, vehicle.p_E).evaluate(times)[0]


def look() -> RotationMatrix:
    """Returns the camera's orientation in the world: x to the right, y down, z forward."""
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return RotationMatrix(np.column_stack([right, np.cross(forward, right), forward]))


def pixel(point: np.ndarray) -> np.ndarray:
    """Returns the place (2,) of a point (3,) of the world in the picture."""
    x, y, z = look().inverse() @ (point - EYE)
    focal = HEIGHT / 2 / np.tan(VIEW_RAD / 2)
    return np.array([WIDTH / 2 + focal * x / z, HEIGHT / 2 + focal * y / z])


def label(
    axes: Axes, scenario: Scenario, vehicle: VehicleModel, frames: Mapping[str, RigidTransform]
) -> None:
    """Draws the frames, the learning space and the names of the parts over the picture."""
    p_B, p_E, p_O = vehicle.p_B, frames[TOOL_FRAME].translation(), vehicle.p_B + vehicle.p_O
    for low, high in box_edges(p_O, np.array(scenario.allocation.learning_space_m)):
        axes.plot(*np.transpose([pixel(low), pixel(high)]), color=BLUE, linewidth=2)
    for frame in (RigidTransform(p_B), frames[TOOL_FRAME]):
        draw_frame(axes, frame)
    name(axes, "base: frame B at p_B", pixel(p_B), (715, 45), start=(0, 0.5))
    for i, (p, beside) in enumerate(zip(vehicle.rotors.p_B, ROTOR_NAMES, strict=True)):
        axes.text(*(pixel(p_B + p) + beside), f"rotor {i}", fontsize=TEXT, ha="center", color=INK)
    for i, joint in enumerate(vehicle.joint_names):
        place = (20, 430 + 52 * i)
        name(axes, f"q_{i + 1}  {joint}", pixel(frames[joint].translation()), place, start=(1, 0.5))
    name(axes, "tool: frame E at p_E, which is p_O at the start", pixel(p_E), (420, 805))
    corner = p_O + 0.5 * np.array([1, 1, -1]) * scenario.allocation.learning_space_m
    name(axes, "learning space around p_O", pixel(corner), (900, 730), BLUE)
    ahead = pixel(lap(scenario, vehicle)[AHEAD])
    name(axes, "reference p_Ed(t)", ahead, (1300, 370), "#c2410c")


def name(
    axes: Axes,
    text: str,
    point: np.ndarray,
    place: tuple[float, float],
    color: str = INK,
    start: tuple[float, float] = (0.5, 0.5),
) -> None:
    """Writes a name at a place of the picture, with a line from a part of the text to its point."""
    line = {"arrowstyle": "-", "color": color, "linewidth": 1.4, "shrinkB": 0, "relpos": start}
    axes.annotate(text, point, place, fontsize=TEXT, color=color, va="center", arrowprops=line)
    axes.plot(*point, marker="o", color=color, markersize=6, markeredgecolor="white")


def draw_frame(axes: Axes, pose: RigidTransform) -> None:
    """Draws the axes of a frame, x red, y green, z blue."""
    start = pixel(pose.translation())
    for column, (axis, color) in enumerate(zip("xyz", AXIS_COLORS, strict=True)):
        end = pixel(pose.translation() + AXIS_M * pose.rotation().matrix()[:, column])
        arrow = {"arrowstyle": "-|>", "color": color, "linewidth": 3, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", end, start, arrowprops=arrow)
        axes.annotate(axis, end, end + 0.16 * (end - start), fontsize=TEXT - 3, color=color)


def box_edges(centre: np.ndarray, size: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yields the ends of the twelve edges of a box that is parallel to the world's axes."""
    corners = [np.array(signs) for signs in product((-0.5, 0.5), repeat=3)]
    for low, high in combinations(corners, 2):
        if np.count_nonzero(low != high) == 1:
            yield centre + low * size, centre + high * size


if __name__ == "__main__":
    main()

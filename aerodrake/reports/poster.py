"""Still picture of a flight, for where its replay cannot be shown.

It needs neither a graphics card nor OpenGL: triangles are projected, sorted by their distance and
drawn by Matplotlib.
"""

import base64
import io
from functools import cache
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Mesh,
    QueryObject,
    ReadObjToTriangleSurfaceMesh,
    Rgba,
    Role,
    Sphere,
)
from scipy.spatial import ConvexHull

from aerodrake.flight.log import FlightLog
from aerodrake.gallery.camera import NEAREST_M, Camera
from aerodrake.reports.drawable import drawable
from aerodrake.reports.figures import ACCENT, INK, STYLE
from aerodrake.reports.replay import BASE, finite_points, replay_frames
from aerodrake.reports.scene import VIEW_FROM_M, posed_scene
from aerodrake.scenario import Scenario

SIZE_PX = (1080, 720)
FIELD_OF_VIEW_RAD = np.radians(50.0)
"""Vertical angle of the picture."""
LIGHT = np.array([0.35, 0.5, 0.8])
"""(3,) direction to the light, in the world."""
SHADE = 0.45
"""Brightness of a surface parallel to the light."""
SKY = "#e3e7ea"
MOST_POINTS = 3000
"""Largest number of points of a path."""
STEPS = 14
"""Number of points around a cylinder or sphere."""


def poster(log: FlightLog, scenario: Scenario) -> str:
    """Returns a PNG in base64: the vehicle at the start of the replay, its path and reference."""
    log = drawable(log)
    _, positions = replay_frames(log)
    middle = np.median(positions[:, BASE], axis=0)
    camera = Camera(middle + VIEW_FROM_M, middle, *SIZE_PX, FIELD_OF_VIEW_RAD)
    stride = -(-len(log.time_s) // MOST_POINTS)
    flown = np.flatnonzero(log.is_flown)[::stride]
    with rc_context(STYLE):
        figure = Figure(figsize=(9, 6), dpi=SIZE_PX[0] / 9, facecolor=SKY)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        for key, style in (
            ("p_Ed_m", {"color": INK, "linewidth": 1.2, "linestyle": ":"}),
            ("p_E_m", {"color": ACCENT, "linewidth": 2.0}),
        ):
            points, depth = camera.project(finite_points(log[key][flown]))
            axes.plot(*points[depth > NEAREST_M].T, **style)
        with posed_scene(scenario, log.vehicle, positions[0]) as query:
            triangles, colors = _surfaces(query)
        points, depth = camera.project(triangles)
        is_shown = depth.min(axis=1) > NEAREST_M
        order = np.argsort(-depth[is_shown].mean(axis=1), kind="stable")
        faces = colors[is_shown][order]
        # Edges hide the seams between opaque faces.
        edges = 0.3 * (faces[:, 3] == 1)
        shapes = PolyCollection(
            points[is_shown][order], facecolors=faces, edgecolors=faces, linewidths=edges, zorder=3
        )
        axes.add_collection(shapes, autolim=False)
        axes.set(xlim=(0, camera.width), ylim=(camera.height, 0))
        file = io.BytesIO()
        FigureCanvasAgg(figure).print_png(
            file, metadata={"Software": None}, pil_kwargs={"optimize": True}
        )
    return base64.b64encode(file.getvalue()).decode()


def _surfaces(query: QueryObject) -> tuple[np.ndarray, np.ndarray]:
    """Returns the triangles (K, 3, 3) m of visible geometry in the world, and colours (K, 4)."""
    inspector = query.inspector()
    triangles, colors = [np.empty((0, 3, 3))], [np.empty((0, 4))]
    for geometry in inspector.GetAllGeometryIds(Role.kIllustration):
        own = _triangles(inspector.GetShape(geometry))
        X = query.GetPoseInWorld(geometry)
        own = own @ X.rotation().matrix().T + X.translation()
        properties = inspector.GetIllustrationProperties(geometry)
        color = properties.GetPropertyOrDefault("phong", "diffuse", Rgba(0.6, 0.6, 0.6, 1.0))
        normal = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        facing = np.abs(normal @ (LIGHT / np.linalg.norm(LIGHT)))
        shade = (SHADE + (1 - SHADE) * facing)[:, None]
        rgb = np.array([color.r(), color.g(), color.b()])
        triangles.append(own)
        colors.append(np.hstack([shade * rgb, np.full_like(shade, color.a())]))
    return np.concatenate(triangles), np.concatenate(colors)


def _triangles(shape: Any) -> np.ndarray:
    """Returns the triangles (K, 3, 3) m of a shape in its frame; none of one that is unbounded."""
    match shape:
        case Box():
            return _hull(_corners() * shape.size() / 2)
        case Sphere():
            return _hull(_sphere() * shape.radius())
        case Ellipsoid():
            return _hull(_sphere() * [shape.a(), shape.b(), shape.c()])
        case Cylinder():
            return _hull(_rings() * [shape.radius(), shape.radius(), shape.length() / 2])
        case Capsule():
            end = [0.0, 0.0, shape.length() / 2]
            ball = _sphere() * shape.radius()
            return _hull(np.concatenate([ball + end, ball - end]))
        case Mesh() if shape.extension() == ".obj":
            mesh = ReadObjToTriangleSurfaceMesh(shape.source().path(), shape.scale3())
            corners = [[t.vertex(i) for i in range(3)] for t in mesh.triangles()]
            return np.array(mesh.vertices())[corners]
        case _ if hasattr(shape, "GetConvexHull"):
            return _hull(np.array(shape.GetConvexHull().vertices()))
    return np.empty((0, 3, 3))


def _hull(points: np.ndarray) -> np.ndarray:
    """Returns the triangles (K, 3, 3) of the convex hull of points (N, 3)."""
    return points[ConvexHull(points).simplices]


@cache
def _corners() -> np.ndarray:
    """Returns (8, 3), the corners of a cube with edges of 2."""
    return np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)


@cache
def _rings() -> np.ndarray:
    """Returns (2 STEPS, 3), points on both edges of a cylinder of radius 1 and length 2."""
    turn = np.linspace(0, 2 * np.pi, STEPS, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.ones(STEPS)])
    return np.concatenate([ring, ring * [1, 1, -1]])


@cache
def _sphere() -> np.ndarray:
    """Returns (N, 3), points on a sphere of radius 1."""
    height = np.linspace(-1, 1, STEPS // 2 + 1)[:, None, None]
    ring = _rings()[:STEPS, :2] * np.sqrt(1 - height**2)
    heights = np.broadcast_to(height, (*ring.shape[:2], 1))
    return np.concatenate([ring, heights], axis=2).reshape(-1, 3)

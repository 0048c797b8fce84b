"""Collision geometry of an arm: one box for each link, around its geometry."""

from dataclasses import replace

import numpy as np

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.link import ArmLink, Geometry
from aerodrake.mounting.listed import shown
from aerodrake.mounting.meshes import bounds
from aerodrake.mounting.pose import Pose
from aerodrake.support.errors import BadInput

SIGNS = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
"""(8, 3), corners of a cube with edges of 2."""
LEAST_EDGE_M = 1e-3
"""Smallest edge of a box."""

LARGEST_M = 10.0
"""Largest edge of a mesh's bounding box. A mesh in mm without a scale is larger."""


def check_meshes(arm: ArmTree) -> Converted:
    """Returns the arm as it is.

    Raises:
        BadInput: if a mesh is too large to be a part of an arm.
    """
    for link in arm.links:
        for geometry in (*link.visuals, *link.collisions):
            points = corners(geometry) if geometry.file else np.empty((0, 3))
            if len(points) and (size := np.ptp(points, axis=0).max()) > LARGEST_M:
                problem = f"expected meshes of {LARGEST_M:g} m or less, got {geometry.file.name} of"
                advice = 'one in mm needs <mesh scale="0.001 0.001 0.001">'
                raise BadInput("", f"link {link.name}", f"{problem} {shown(size)} m; {advice}")
    return Converted(arm)


def box_links(arm: ArmTree) -> Converted:
    """Replaces the collision geometry of each link by one box in the link's frame.

    The box contains the collision geometry, or the visual geometry of links without any. Landings
    need the size of the links, and Drake needs convex shapes.
    """
    links = tuple(replace(link, collisions=_boxes(link)) for link in arm.links)
    sentence = "collision geometry becomes one box around each link"
    has_some = any(link.collisions for link in links)
    return Converted(replace(arm, links=links), (sentence,) if has_some else ())


def _boxes(link: ArmLink) -> tuple[Geometry, ...]:
    for geometries in (link.collisions, link.visuals):
        points = [corners(geometry) for geometry in geometries]
        if points and len(cloud := np.concatenate(points)):
            lower, upper = cloud.min(axis=0), cloud.max(axis=0)
            size = np.maximum(upper - lower, LEAST_EDGE_M)
            centre = Pose(tuple(((lower + upper) / 2).tolist()))
            return (Geometry(centre, "box", tuple(size.tolist())),)
    return ()


def bounding_points(link: ArmLink) -> np.ndarray:
    """Returns the corners (N, 3) m of the bounding boxes of all geometry of a link."""
    points = [corners(geometry) for geometry in (*link.visuals, *link.collisions)]
    return np.concatenate([np.empty((0, 3)), *points])


def corners(geometry: Geometry) -> np.ndarray:
    """Returns the corners (8, 3) m of a geometry's bounding box in the link's frame.

    The box is aligned with the geometry. The result is empty (0, 3) for a mesh without faces.
    """
    X, numbers = geometry.origin.transform(), np.array(geometry.numbers)
    half, centre = np.empty(3), np.zeros(3)
    match geometry.shape:
        case "box":
            half = numbers / 2
        case "sphere":
            half = np.full(3, numbers[0])
        case "cylinder":
            half = np.array([numbers[0], numbers[0], numbers[1] / 2])
        case "drake:capsule":
            half = np.array([numbers[0], numbers[0], numbers[1] / 2 + numbers[0]])
        case "drake:ellipsoid":
            half = numbers
        case "mesh":
            box = bounds(geometry.file)
            if not len(box):
                return box
            half, centre = np.abs(numbers) * np.ptp(box, axis=0) / 2, numbers * box.mean(axis=0)
    return np.array([X @ (centre + signs * half) for signs in SIGNS])

"""Collision geometry of an arm: one box for each link, around its geometry."""

from dataclasses import replace

import numpy as np

from aerodrake.mounting.arm import ArmLink, ArmTree, Converted, Geometry, Pose
from aerodrake.mounting.meshes import bounds

SIGNS = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
"""(8, 3), corners of a cube with edges of 2."""
LEAST_M = 1e-3
"""Smallest edge of a box."""


def box_links(arm: ArmTree) -> Converted:
    """Replaces the collision geometry of each link by one box in the link's frame.

    The box contains the collision geometry, or the visual geometry of links without any. Landings
    need the size of the links, and Drake needs convex shapes.
    """
    links = tuple(replace(link, collisions=_boxes(link)) for link in arm.links)
    count = sum(len(link.collisions) for link in links)
    sentence = f"collision geometry becomes one box around each of {count} links"
    return Converted(replace(arm, links=links), (sentence,) if count else ())


def _boxes(link: ArmLink) -> tuple[Geometry, ...]:
    for geometries in (link.collisions, link.visuals):
        points = [corners(geometry) for geometry in geometries]
        if points and len(cloud := np.concatenate(points)):
            lower, upper = cloud.min(axis=0), cloud.max(axis=0)
            size = np.maximum(upper - lower, LEAST_M)
            centre = Pose(tuple(((lower + upper) / 2).tolist()))
            return (Geometry(centre, "box", tuple(size.tolist())),)
    return ()


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

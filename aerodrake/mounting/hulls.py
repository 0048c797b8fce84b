"""Masses of links, estimated from the convex hulls of their geometry."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.inertias import DENSITY_KG_M3, moments_of
from aerodrake.mounting.link import Geometry, Inertial
from aerodrake.mounting.listed import listed, shown
from aerodrake.mounting.meshes import load_parts
from aerodrake.mounting.pose import Pose

if TYPE_CHECKING:
    import trimesh


def estimate_masses(arm: ArmTree) -> Converted:
    """Estimates all masses and inertias of an arm without any; returns other arms unchanged.

    Each link fills the convex hulls of its visual geometry with a typical density, or those of its
    collision geometry if no link that is fixed to it has visual geometry: some URDFs describe a
    link a second time for collisions alone. URDFs for planning alone have no masses.
    """
    if arm.mass:
        return Converted(arm)
    bodies = {link.name: _body(arm, link.name) for link in arm.links}
    seen = {bodies[link.name] for link in arm.links if link.visuals}
    links = tuple(
        replace(
            link,
            inertial=_estimated(link.visuals if bodies[link.name] in seen else link.collisions),
        )
        for link in arm.links
    )
    arm = replace(arm, links=links)
    if not arm.mass:
        return Converted(arm)
    masses = listed(f"{link.name} {shown(link.mass)}" for link in links if link.mass)
    law = f"{DENSITY_KG_M3:g} kg/m^3 in the convex hulls of the links"
    sentence = f"no link has a mass; {law} give {shown(arm.mass)} kg: {masses}"
    return Converted(arm, (sentence,))


def _body(arm: ArmTree, link: str) -> str:
    """Returns the highest link that a link is fixed to."""
    while link in arm.above and not arm.above[link].is_moving:
        link = arm.above[link].parent
    return link


def _estimated(geometries: Sequence[Geometry]) -> Inertial | None:
    """Returns the inertia of a link that fills convex hulls; None without volume."""
    import trimesh

    hulls = [_hull(geometry) for geometry in geometries]
    if not (solid := [hull for hull in hulls if hull is not None]):
        return None
    body = trimesh.util.concatenate(solid)
    body.density = DENSITY_KG_M3
    centre = Pose(tuple(body.center_mass.tolist()))
    return Inertial(centre, float(body.mass), moments_of(body.moment_inertia))


def _hull(geometry: Geometry) -> "trimesh.Trimesh | None":
    """Returns the convex hull of a geometry in the link's frame; None without volume."""
    import trimesh
    from scipy.spatial import QhullError

    points = _points(geometry)
    try:
        hull = trimesh.convex.convex_hull(points)
    except (QhullError, ValueError):  # Fewer than four points, or all in one plane.
        return None
    hull.apply_transform(geometry.origin.transform().GetAsMatrix4())
    return hull if hull.volume > 0 else None


def _points(geometry: Geometry) -> np.ndarray:
    """Returns points (N, 3) m whose convex hull is a geometry, in its frame."""
    from trimesh import creation

    numbers = geometry.numbers
    match geometry.shape:
        case "box":
            return creation.box(numbers).vertices
        case "sphere":
            return creation.icosphere(radius=numbers[0]).vertices
        case "cylinder":
            return creation.cylinder(*numbers).vertices
        case "drake:capsule":
            return creation.capsule(height=numbers[1], radius=numbers[0]).vertices
        case "drake:ellipsoid":
            return creation.icosphere().vertices * numbers
    vertices = [part.vertices for part in load_parts(geometry.file)]
    return np.concatenate([np.empty((0, 3)), *vertices]) * numbers

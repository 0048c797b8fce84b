"""Masses and inertias that a simulation needs, for links that lack them."""

from dataclasses import replace

import numpy as np
from pydrake.multibody.tree import RotationalInertia

from aerodrake.model.vehicle.robot import ball_radius
from aerodrake.model.vehicle.urdf_links import MARKER_KG, ROUNDING
from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.collision import LEAST_EDGE_M, bounding_points
from aerodrake.mounting.link import ArmLink, Inertial
from aerodrake.mounting.listed import listed, shown
from aerodrake.mounting.pose import Pose
from aerodrake.support.errors import BadInput

DENSITY_KG_M3 = 1000.0
"""Density of links without a mass or inertia, in their convex hulls or as solid spheres: about the
median of real arms in their hulls."""
LEAST_MASS_SHARE = 0.01
"""Mass of a moving link with no mass from there on, as a share of the arm's mass."""
LEAST_RATIO = 1e-6
"""Smallest principal moment of a corrected inertia, as a share of the largest."""
MARGIN = 1e-9
"""Relative margin to the triangle inequality of the principal moments."""

LARGEST_GYRATION = 5.0
"""Radius of gyration over the distance of the link's farthest geometry, above which an inertia is
a placeholder. No body has more than 1, but published arms with more than 4 fly well."""


def correct_inertias(arm: ArmTree) -> Converted:
    """Completes missing masses and inertias, and corrects those that no body can have.

    Raises:
        BadInput: if no link has a mass.
    """
    if not arm.mass:
        problem = "expected links with a <mass> in their <inertial>, or with geometry"
        raise BadInput("", "", f"{problem}; --package-path finds meshes in other folders")
    links = {link.name: _corrected(link) for link in arm.links}
    by_change: dict[str, list[str]] = {}
    for link, change in links.values():
        if change:
            by_change.setdefault(change, []).append(link.name)
    changes = [f"{change}: {listed(names)}" for change, names in by_change.items()]
    arm = arm.with_links({name: link for name, (link, _) in links.items()})
    mass = LEAST_MASS_SHARE * arm.mass
    light = [
        joint.child
        for joint in arm.joints
        if joint.is_moving and not any(arm.link(name).mass for name in arm.below(joint.child))
    ]
    if light:
        parts = {name: replace(arm.link(name), inertial=_sphere(Pose(), mass)) for name in light}
        arm = arm.with_links(parts)
        kg = f"{shown(mass)} kg, {LEAST_MASS_SHARE:.0%} of the arm's mass"
        changes.append(f"moving links with no mass from there on get {kg}: {listed(light)}")
    return Converted(arm, tuple(changes))


def _corrected(link: ArmLink) -> tuple[ArmLink, str]:
    """Returns a link with a valid inertia or without any, and the change."""
    inertial = link.inertial
    if inertial is None:
        return link, ""
    if inertial.mass <= MARKER_KG:
        return replace(link, inertial=None), "an <inertial> without mass is removed"
    if not any(inertial.moments):
        sphere = _sphere(inertial.origin, inertial.mass)
        name = f"a solid sphere of {DENSITY_KG_M3:g} kg/m^3"
        return replace(link, inertial=sphere), f"a zero inertia becomes that of {name}"
    if (box := _box_inertia(link, inertial)) is not None:
        change = "an inertia far too large for a link's geometry becomes that of a box around it"
        return replace(link, inertial=box), change
    moments = physical(inertial.moments)
    if moments == inertial.moments:
        return link, ""
    change = "principal moments of inertia that no body has are raised to the nearest ones"
    return replace(link, inertial=replace(inertial, moments=moments)), change


def physical(moments: tuple[float, ...]) -> tuple[float, ...]:
    """Returns moments of inertia that a body can have: the same ones, if it can.

    Otherwise the principal moments are raised until all are positive and each is at most the sum
    of the others.

    Args:
        moments: kg m^2, ixx, iyy, izz, ixy, ixz, iyz.
    """
    principal, axes = np.linalg.eigh(inertia_matrix(moments))
    largest = max(abs(principal))
    is_positive = min(principal) > ROUNDING * largest
    if is_positive and RotationalInertia(*moments).CouldBePhysicallyValid():
        return moments
    order = np.argsort(np.abs(principal))
    raised = np.maximum(np.abs(principal[order]), LEAST_RATIO * largest)
    lacking = raised[2] * (1 + MARGIN) - raised[0] - raised[1]
    raised[:2] += max(lacking, 0.0) / 2
    return moments_of(axes[:, order] @ np.diag(raised) @ axes[:, order].T)


def inertia_matrix(moments: tuple[float, ...]) -> np.ndarray:
    """Returns the matrix (3, 3) of moments of inertia in the order of `Inertial.moments`."""
    ixx, iyy, izz, ixy, ixz, iyz = moments
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


def moments_of(matrix: np.ndarray) -> tuple[float, ...]:
    """Returns the moments of inertia of a matrix (3, 3), in the order of `Inertial.moments`."""
    return tuple(matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist())


def _box_inertia(link: ArmLink, inertial: Inertial) -> Inertial | None:
    """Returns the inertia of a solid box around a link, if its own is a placeholder; else None."""
    if not len(points := bounding_points(link)):
        return None
    farthest = np.linalg.norm(points - inertial.origin.xyz, axis=1).max()
    largest = max(np.linalg.eigvalsh(inertia_matrix(inertial.moments)))
    if largest <= inertial.mass * (LARGEST_GYRATION * farthest) ** 2:
        return None
    squares = np.ptp(points, axis=0) ** 2 + LEAST_EDGE_M**2
    moments = inertial.mass / 12 * (squares.sum() - squares)
    return Inertial(Pose(inertial.origin.xyz), inertial.mass, (*moments.tolist(), 0.0, 0.0, 0.0))


def _sphere(origin: Pose, mass: float) -> Inertial:
    """Returns the inertia of a solid sphere of the default density."""
    moment = 0.4 * mass * ball_radius(mass, DENSITY_KG_M3) ** 2
    return Inertial(origin, mass, (moment, moment, moment, 0.0, 0.0, 0.0))

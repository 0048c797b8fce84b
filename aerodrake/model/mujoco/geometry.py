"""Collision geometry of a robot in MuJoCo: shapes, and pairs of them that may touch."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from mujoco import MjsBody, MjsGeom, MjSpec, mjtGeom
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    HalfSpace,
    Mesh,
    SceneGraphInspector,
    Sphere,
)
from pydrake.multibody.plant import CalcContactFrictionFromSurfaceProperties, MultibodyPlant
from pydrake.multibody.tree import BodyIndex

SLIDING_AND_NORMAL = 3
"""Dimension of a contact: its normal force and two friction forces."""
THINNEST = 1e-5
"""Smallest ratio of a mesh's thickness to its size, since MuJoCo has no hull of flat ones."""


def add_contacts(
    spec: MjSpec,
    bodies: Mapping[BodyIndex, MjsBody],
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
) -> None:
    """Adds the geometry that may touch other geometry, and each such pair, to a specification.

    Pairs are those that Drake's collision filters leave. Their coefficient of friction is Drake's
    dynamic one, which its discrete plants use, from the same law of combination.

    Args:
        spec: The specification.
        bodies: Its bodies, by their indices in the plant.
        plant: Finalised plant, registered with a SceneGraph.
        inspector: Inspector of the SceneGraph.
    """
    pairs = sorted(
        sorted(pair, key=GeometryId.get_value) for pair in inspector.GetCollisionCandidates()
    )
    names: dict[GeometryId, str] = {}
    for geometry in sorted({geometry for pair in pairs for geometry in pair}):
        names[geometry] = f"geometry_{len(names)}"
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        pose = inspector.GetPoseInFrame(geometry)
        geom = bodies[body.index()].add_geom(
            name=names[geometry],
            pos=pose.translation(),
            quat=pose.rotation().ToQuaternion().wxyz(),
            contype=0,  # Only the pairs below can touch.
            conaffinity=0,
        )
        _set_shape(spec, geom, inspector, geometry)
    for first, second in pairs:
        friction = CalcContactFrictionFromSurfaceProperties(
            *(
                inspector.GetProximityProperties(geometry).GetProperty(
                    "material", "coulomb_friction"
                )
                for geometry in (first, second)
            )
        ).dynamic_friction()
        spec.add_pair(
            geomname1=names[first],
            geomname2=names[second],
            condim=SLIDING_AND_NORMAL,
            friction=[friction, friction, 0, 0, 0],
        )


def _set_shape(
    spec: MjSpec, geom: MjsGeom, inspector: SceneGraphInspector, geometry: GeometryId
) -> None:
    """Gives a geom the shape of a geometry; a mesh becomes its convex hull, as in Drake."""
    shape: Any = inspector.GetShape(geometry)
    match shape:
        case Mesh() | Convex():
            hull = inspector.GetConvexHull(geometry)
            vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
            spec.add_mesh(name=geom.name, uservert=_solid(vertices).ravel())
            geom.type, geom.meshname = mjtGeom.mjGEOM_MESH, geom.name
        case Box():
            geom.type, geom.size = mjtGeom.mjGEOM_BOX, shape.size() / 2
        case Sphere():
            geom.type, geom.size[0] = mjtGeom.mjGEOM_SPHERE, shape.radius()
        case Cylinder() | Capsule():
            is_capsule = isinstance(shape, Capsule)
            geom.type = mjtGeom.mjGEOM_CAPSULE if is_capsule else mjtGeom.mjGEOM_CYLINDER
            geom.size[:2] = shape.radius(), shape.length() / 2
        case Ellipsoid():
            geom.type, geom.size = mjtGeom.mjGEOM_ELLIPSOID, [shape.a(), shape.b(), shape.c()]
        case HalfSpace():
            geom.type, geom.size = mjtGeom.mjGEOM_PLANE, [0, 0, 1]  # Without borders.
        case _:
            raise TypeError(f"no equivalent in MuJoCo: {shape}")


def _solid(vertices: np.ndarray) -> np.ndarray:
    """Returns vertices (m, 3), with copies on both sides of their plane if all are in one."""
    _, sizes, axes = np.linalg.svd(vertices - vertices.mean(axis=0), full_matrices=False)
    if sizes[2] > THINNEST * sizes[0]:
        return vertices
    normal = THINNEST * sizes[0] * axes[2]
    return np.concatenate([vertices - normal, vertices + normal])

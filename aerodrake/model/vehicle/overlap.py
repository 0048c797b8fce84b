"""Overlap of a robot's collision geometry with itself."""

from typing import NamedTuple

import numpy as np
from pydrake.geometry import GeometryId, SceneGraph
from pydrake.multibody.plant import MultibodyPlant


class Overlap(NamedTuple):
    """Two links whose collision geometry overlaps.

    Attributes:
        links: Their names.
        depth: m, depth of the overlap.
    """

    links: tuple[str, str]
    depth: float


def deepest_overlap(
    plant: MultibodyPlant, scene_graph: SceneGraph, positions: np.ndarray
) -> Overlap | None:
    """Returns the deepest of the `overlaps` at positions (7 + n,); None if there is none."""
    every = overlaps(plant, scene_graph, positions)
    return max(every, key=lambda overlap: overlap.depth, default=None)


def overlaps(
    plant: MultibodyPlant, scene_graph: SceneGraph, positions: np.ndarray
) -> list[Overlap]:
    """Returns the overlaps of links that may collide.

    Links that are connected by a joint, or are in a collision filter group, cannot collide.

    Args:
        plant: Finalised plant of the robot alone, registered with a SceneGraph.
        scene_graph: The SceneGraph with its geometry.
        positions: (7 + n,) generalized positions.
    """
    context, scene = plant.CreateDefaultContext(), scene_graph.CreateDefaultContext()
    plant.SetPositions(context, positions)
    poses = plant.get_geometry_pose_output_port().Eval(context)
    scene_graph.get_source_pose_port(plant.get_source_id()).FixValue(scene, poses)
    query = scene_graph.get_query_output_port().Eval(scene)
    inspector = scene_graph.model_inspector()

    def link(geometry: GeometryId) -> str:
        return plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()

    pairs = query.ComputePointPairPenetration()
    return [Overlap((link(pair.id_A), link(pair.id_B)), pair.depth) for pair in pairs]

"""Where the arm goes for a landing: up, out of the way of the ground."""

from __future__ import annotations

import numpy as np
from pydrake.geometry import SceneGraph, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, RigidBody
from scipy.optimize import minimize

from aerodrake.model.vehicle.state import BASE_POSITIONS

CLEARANCE_M = 0.1
"""By how much all of the arm is to be higher than the base's lowest point."""
MARGIN_RAD = 0.05
"""What joints keep from their limits, where the working configuration does."""
TOLERANCE_M = 1e-6
"""By how much less is high enough."""
STARTS = 16
"""Configurations to search from if the working one leads to none that is high enough."""


class GroundGeometry:
    """What of a robot could touch the ground: its collision geometry, as the boxes around it.

    Attributes:
        feet: m, the base's lowest point in its frame; 0 if nothing of it collides.
        lower, upper: (n,) rad, limits of the joints.
    """

    def __init__(self, plant: MultibodyPlant, scene_graph: SceneGraph, base: str):
        """Of a robot.

        Args:
            plant: With the robot alone, finalised, and registered with
            scene_graph: Its geometry.
            base: The link that the arm is on.
        """
        inspector = scene_graph.model_inspector()
        link = plant.GetBodyByName(base)
        corners = {
            body: _corners(plant, inspector, body)
            for body in map(plant.get_body, plant.GetBodyIndices(link.model_instance()))
        }
        own = corners.pop(link)[2]
        self.feet = float(own.min()) if own.size else 0.0
        self.lower = plant.GetPositionLowerLimits()[BASE_POSITIONS:]
        self.upper = plant.GetPositionUpperLimits()[BASE_POSITIONS:]
        self._arm = [(body, points) for body, points in corners.items() if points.size]
        self._plant, self._base = plant, link.body_frame()
        self._context = plant.CreateDefaultContext()

    def heights(self, q: np.ndarray) -> np.ndarray:
        """(c,) m, of the corners of the arm's boxes in the base frame, at angles q (n,) rad."""
        self._set(q)
        heights = [
            self._plant.CalcPointsPositions(self._context, body.body_frame(), points, self._base)[2]
            for body, points in self._arm
        ]
        return np.concatenate([np.empty(0), *heights])

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """(c, n) m/rad, of the heights at angles q (n,) rad."""
        self._set(q)
        return np.vstack(
            [
                self._plant.CalcJacobianTranslationalVelocity(
                    self._context,
                    JacobianWrtVariable.kQDot,
                    body.body_frame(),
                    points,
                    self._base,
                    self._base,
                )[2::3, BASE_POSITIONS:]
                for body, points in self._arm
            ]
        )

    def _set(self, q: np.ndarray) -> None:
        positions = self._plant.GetDefaultPositions()
        positions[BASE_POSITIONS:] = q
        self._plant.SetPositions(self._context, positions)


def tuck(geometry: GroundGeometry, working: np.ndarray) -> np.ndarray:
    """(n,) rad, the configuration next to the working one with all of the arm high enough.

    That is `CLEARANCE_M` above the feet, of the boxes around its geometry and so of what is in
    them. Found by sequential quadratic programming from the working configuration, or else
    from others spread over the joints' range; where there is none, that with the highest
    lowest corner.

    Args:
        geometry: Of the robot.
        working: (n,) rad, within the joints' limits.
    """
    n, corners = len(working), len(geometry.heights(working))
    if not corners:
        return working.copy()
    least = geometry.feet + CLEARANCE_M
    lower = np.minimum(geometry.lower + MARGIN_RAD, working)
    upper = np.maximum(geometry.upper - MARGIN_RAD, working)
    box = list(zip(lower, upper, strict=True))

    def clearance(q: np.ndarray) -> float:
        return float(geometry.heights(q).min()) - least

    def distance(q: np.ndarray) -> float:
        return float(np.sum((q - working) ** 2))

    def nearest(start: np.ndarray) -> np.ndarray:
        above = {
            "type": "ineq",
            "fun": lambda q: geometry.heights(q) - least,
            "jac": geometry.jacobian,
        }
        found = minimize(
            lambda q: (distance(q), 2 * (q - working)),
            start,
            jac=True,
            method="SLSQP",
            bounds=box,
            constraints=above,
        )
        return np.clip(found.x, lower, upper)

    def highest(start: np.ndarray) -> np.ndarray:
        """By the height h that all corners reach, with x = [q, h]."""
        up = np.eye(n + 1)[n]
        above = {
            "type": "ineq",
            "fun": lambda x: geometry.heights(x[:n]) - x[n],
            "jac": lambda x: np.column_stack([geometry.jacobian(x[:n]), -np.ones(corners)]),
        }
        found = minimize(
            lambda x: (-x[n], -up),
            np.append(start, geometry.heights(start).min()),
            jac=True,
            method="SLSQP",
            bounds=[*box, (None, None)],
            constraints=above,
        )
        return np.clip(found.x[:n], lower, upper)

    found = nearest(working)
    if clearance(found) >= -TOLERANCE_M:
        return found
    from scipy.stats.qmc import Halton  # A third of a second of every start that needs it not.

    spread = lower + (upper - lower) * Halton(n, scramble=False).random(STARTS)
    raised = [highest(start) for start in (working, *spread)]
    near = [q for start in raised if clearance(q := nearest(start)) >= -TOLERANCE_M]
    return min(near, key=distance) if near else max(raised, key=clearance)


def _corners(plant: MultibodyPlant, inspector: SceneGraphInspector, body: RigidBody) -> np.ndarray:
    """(3, 8 g) m, of the boxes around its g collision geometries, in its frame."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8)
    boxes = [np.empty((3, 0))]
    for geometry in plant.GetCollisionGeometriesForBody(body):
        box = inspector.GetObbInGeometryFrame(geometry)
        if box is None:  # Half spaces have none.
            continue
        pose = inspector.GetPoseInFrame(geometry).multiply(box.pose())
        boxes.append(pose.multiply(signs * box.half_width().reshape(3, 1)))
    return np.hstack(boxes)

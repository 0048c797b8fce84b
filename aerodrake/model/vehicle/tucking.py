"""Tucked configuration of the arm for a landing, away from the ground."""

from collections.abc import Callable

import numpy as np
from pydrake.geometry import SceneGraph, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, RigidBody
from scipy.optimize import minimize

from aerodrake.model.vehicle.state import BASE_POSITIONS

CLEARANCE_M = 0.1
"""Required height of the arm above the base's lowest point."""
MARGIN_RAD = 0.05
"""Distance of joints from their limits, unless the working configuration is closer."""
TOLERANCE_M = 1e-6
"""Accepted violation of the clearance."""
STARTS = 16
"""Number of further start configurations, if the search from the working one fails."""


class GroundGeometry:
    """Bounding boxes of a robot's collision geometry, which could touch the ground.

    Attributes:
        feet: m, the base's lowest point in its frame; 0 without collision geometry.
        lower, upper: (n,) rad, limits of the joints.

    Args:
        plant: Finalised plant of the robot alone, registered with a SceneGraph.
        scene_graph: The SceneGraph with its geometry.
        base: Name of the link that the arm is mounted on.
    """

    def __init__(self, plant: MultibodyPlant, scene_graph: SceneGraph, base: str):
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
        """Returns the heights (c,) m of the arm's box corners in the base frame at q (n,) rad."""
        self._set(q)
        heights = [
            self._plant.CalcPointsPositions(self._context, body.body_frame(), points, self._base)[2]
            for body, points in self._arm
        ]
        return np.concatenate([np.empty(0), *heights])

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Returns the Jacobian (c, n) m/rad of the heights at q (n,) rad."""
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
    """Returns the configuration (n,) rad nearest to the working one with the arm high enough.

    High enough means `CLEARANCE_M` above the feet, for the bounding boxes of its collision
    geometry. Sequential quadratic programming starts from the working configuration, or else from
    others spread over the joints' range. If no result is high enough, returns the one whose
    lowest corner is highest.

    Args:
        geometry: Collision geometry of the robot.
        working: (n,) rad, within the joints' limits.
    """
    if not len(geometry.heights(working)):
        return working.copy()
    n, least = len(working), geometry.feet + CLEARANCE_M
    lower = np.minimum(geometry.lower + MARGIN_RAD, working)
    upper = np.maximum(geometry.upper - MARGIN_RAD, working)
    bounds, up = list(zip(lower, upper, strict=True)), np.eye(n + 1)[n]

    def clearance(q: np.ndarray) -> float:
        return float(geometry.heights(q).min()) - least

    def distance(q: np.ndarray) -> float:
        return float(np.sum((q - working) ** 2))

    def nearest(start: np.ndarray) -> np.ndarray:
        """Minimises the distance from the working configuration with all corners high enough."""
        q = _minimum(
            lambda q: (distance(q), 2 * (q - working)),
            start,
            bounds,
            lambda q: geometry.heights(q) - least,
            geometry.jacobian,
        )
        return np.clip(q, lower, upper)

    def highest(start: np.ndarray) -> np.ndarray:
        """Maximises the height h that all corners reach, with x = [q, h]."""
        heights = geometry.heights(start)
        x = _minimum(
            lambda x: (-x[n], -up),
            np.append(start, heights.min()),
            [*bounds, (None, None)],
            lambda x: geometry.heights(x[:n]) - x[n],
            lambda x: np.column_stack([geometry.jacobian(x[:n]), -np.ones(len(heights))]),
        )
        return np.clip(x[:n], lower, upper)

    tucked = nearest(working)
    if clearance(tucked) >= -TOLERANCE_M:
        return tucked
    from scipy.stats.qmc import Halton  # Importing it takes a third of a second.

    starts = lower + (upper - lower) * Halton(n, scramble=False).random(STARTS)
    raised = [highest(start) for start in (working, *starts)]
    clear = [q for q in map(nearest, raised) if clearance(q) >= -TOLERANCE_M]
    return min(clear, key=distance) if clear else max(raised, key=clearance)


def _minimum(
    cost: Callable[[np.ndarray], tuple[float, np.ndarray]],
    start: np.ndarray,
    bounds: list[tuple[float | None, float | None]],
    margin: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Minimises a cost, given with its gradient, subject to bounds and margin(x) >= 0."""
    above = {"type": "ineq", "fun": margin, "jac": jacobian}
    options = {"method": "SLSQP", "bounds": bounds, "constraints": above}
    return minimize(cost, start, jac=True, **options).x


def _corners(plant: MultibodyPlant, inspector: SceneGraphInspector, body: RigidBody) -> np.ndarray:
    """Returns the corners (3, 8 g) m of the boxes around a body's g collision geometries."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8)
    boxes = [np.empty((3, 0))]
    for geometry in plant.GetCollisionGeometriesForBody(body):
        box = inspector.GetObbInGeometryFrame(geometry)
        if box is None:  # Half spaces have none.
            continue
        pose = inspector.GetPoseInFrame(geometry).multiply(box.pose())
        boxes.append(pose.multiply(signs * box.half_width().reshape(3, 1)))
    return np.hstack(boxes)

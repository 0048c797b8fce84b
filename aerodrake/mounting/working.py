"""Search of the working configuration of a mounted arm."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from scipy.optimize import minimize

from aerodrake.model.vehicle.overlap import Overlap, overlaps
from aerodrake.mounting.posture import Posture, Postures
from aerodrake.mounting.spread import spread
from aerodrake.support.errors import BadInput

SAMPLES = 512
"""Number of configurations that are compared: spread over the joints' range, in every second one
with some joints as near to zero as they can be."""
STARTS, STEPS = (12, 3), (10, 60)
"""Number of configurations that are improved, and of steps, in a first and in a second round."""
GRADIENT_RAD = 1e-6
"""Step of the differences for gradients."""
RANK = 1e-3
"""Median of a singular value, relative to the reach or the largest, that counts as zero."""
ALWAYS = 0.9
"""Share of all configurations above which an overlap of two links is a matter of their shapes."""
DEEP_M = 1e-4
"""Depth of an overlap that counts."""
DOWN = np.array([0.0, 0.0, -1.0])

DEXTERITY, LIMIT_RAD, LIMIT_PART = 0.7, 0.5, 0.25
"""Singular value relative to the arm's largest, and distance from a joint's limits, in rad and as
part of its range, from which a configuration is not better for more."""
TORQUE, DEPTH, ACROSS = 0.3, 0.5, 0.35
"""Likewise torque over its limit, and the depth and horizontal distance of the tool below and from
the mount over the arm's reach."""


@dataclass(frozen=True)
class Working:
    """Working configuration of an arm, and measures of it.

    Attributes:
        q: (n,) rad.
        posture: The posture there.
        inertia: kg m^2, largest moment of the arm about a horizontal axis through the base's
            origin.
        dexterity: Smallest singular value of the position's Jacobian over the largest one that
            the arm has in any of the sampled configurations.
        margin: Smallest distance of a joint from its limits, in rad.
        torques: (n,) joint torques in hover over their limits.
        overlap: Deepest overlap of links there; None if there is none.
        cost: The cost of the search there.
        weakest: Index of the joint whose torque is over its limit by most at worst, and the ratio.
    """

    q: np.ndarray
    posture: Posture
    inertia: float
    dexterity: float
    margin: float
    torques: np.ndarray
    overlap: Overlap | None
    cost: float
    weakest: tuple[int, float]

    @property
    def torque(self) -> float:
        """Largest joint torque in hover over its limit."""
        return float(self.torques.max())

    def lines(self) -> tuple[str, ...]:
        """Returns sentences on the measures."""
        return (
            f"tool {-self.posture.tool[2]:.2f} m below the base's origin, "
            f"{np.hypot(*self.posture.tool[:2]):.2f} m beside it",
            f"smallest singular value of the arm's Jacobian {self.dexterity:.0%} of its largest",
            f"{self.margin:.2f} rad or more from joint limits",
            f"joint torques up to {self.torque:.0%} of their limits",
        )


class WorkingSearch:
    """Search among the configurations of an arm.

    Args:
        plant: Finalised plant of the vehicle without collision filters, registered with a
            SceneGraph.
        scene_graph: The SceneGraph with its collision geometry.
        mount: (3,) m, where the arm is mounted, in the base frame.
        reach: m, largest distance of the tool from there.

    Raises:
        BadInput: if the joints do not move the tool.
    """

    def __init__(
        self, plant: MultibodyPlant, scene_graph: SceneGraph, mount: np.ndarray, reach: float
    ):
        self._plant, self._scene_graph = plant, scene_graph
        self._mount, self._reach = mount, reach
        self._postures = Postures(plant)
        self._lower, self._upper = self._postures.lower, self._postures.upper
        n = len(self._lower)
        shares, chance = np.split(spread(SAMPLES, 2 * n), 2, axis=1)
        self._samples = self._lower + shares * (self._upper - self._lower)
        is_home = (chance < 0.5) & (np.arange(SAMPLES)[:, None] % 2 == 1)
        home = np.clip(np.zeros(n), self._lower, self._upper)
        self._samples = np.where(is_home, home, self._samples)
        postures = [self._postures.at(q) for q in self._samples]
        values = np.array([self._singular_values(posture) for posture in postures])
        medians = np.median(values, axis=0)
        if medians[0] <= RANK * reach:
            raise BadInput(
                "tool", "", "expected a tool that the joints move, got one on their axes"
            )
        self._rank = int(np.count_nonzero(medians > RANK * medians[0]))
        self._best = float(values[:, self._rank - 1].max())
        axes = np.array([self._axis_dexterity(posture) for posture in postures])
        self._best_axis = float(axes.max())
        self._torques = np.array([posture.torque for posture in postures])

    def run(self) -> Working:
        """Returns the configuration with the lowest cost, by local searches."""
        bounds = list(zip(self._lower, self._upper, strict=True))
        candidates = list(self._samples)
        for starts, steps in zip(STARTS, STEPS, strict=True):
            options = {"maxiter": steps, "eps": GRADIENT_RAD}
            candidates = [
                minimize(self.cost, q, bounds=bounds, method="L-BFGS-B", options=options).x
                for q in sorted(candidates, key=self.cost)[:starts]
            ]
        ordinary = self._ordinary_overlaps()
        depths = [self._deepest(q, ordinary) for q in candidates]
        costs = [
            self.cost(q) + (1 + deep.depth / self._reach if deep else 0)
            for q, deep in zip(candidates, depths, strict=True)
        ]
        best = int(np.argmin(costs))
        return self._measured(candidates[best], depths[best], costs[best])

    def cost(self, q: np.ndarray) -> float:
        """Returns the cost of joint angles q (n,) rad.

        It is a sum of squares: lack of dexterity of the tool's position, and if the arm has five
        joints or more of its direction; nearness to joint limits; torques above a share of their
        limits; a tool that is not well below the mount, far from its axis, or does not point down;
        horizontal offset of the centre of mass; links above the mount.
        """
        posture = self._postures.at(q)
        tool = (posture.tool - self._mount) / self._reach
        room = np.minimum(LIMIT_RAD, LIMIT_PART * (self._upper - self._lower))
        margins = np.minimum(q - self._lower, self._upper - q) / room
        torque = np.abs(posture.torque) / self._postures.effort
        rises = (posture.highest - self._mount[2]) / self._reach
        terms = {
            "dexterity": 3 * _lack(self._dexterity(posture), DEXTERITY),
            "direction": _lack(self._axis_dexterity(posture) / self._best_axis, 0.5 * DEXTERITY)
            if len(q) > 4
            else 0.0,
            "limits": 2 * np.linalg.norm(np.maximum(0, 1 - margins)),
            "torque": 3 * np.linalg.norm(np.maximum(0, torque / TORQUE - 1)),
            "depth": 3 * _lack(tool[2] / -DEPTH, 1.0),
            "across": 2 * max(0.0, float(np.hypot(*tool[:2])) / ACROSS - 1),
            "pointing": 0.5 * np.linalg.norm(posture.axis - DOWN),
            "balance": 2 * np.hypot(*posture.offset) / self._reach,
            "rise": 4 * max(0.0, rises + 0.05),
            "home": 0.05 * np.linalg.norm(q),
        }
        return float(sum(term**2 for term in terms.values()))

    def _measured(self, q: np.ndarray, overlap: Overlap | None, cost: float) -> Working:
        q = np.clip(np.round(q, 4), self._lower, self._upper) + 0.0  # The sum has no -0.
        posture, effort = self._postures.at(q), self._postures.effort
        loads = np.abs(self._torques).max(axis=0) / effort
        weakest = int(np.argmax(loads))
        return Working(
            q=q,
            posture=posture,
            inertia=self._postures.inertia(q),
            dexterity=self._dexterity(posture),
            margin=float(np.minimum(q - self._lower, self._upper - q).min()),
            torques=np.abs(posture.torque) / effort,
            overlap=overlap,
            cost=cost,
            weakest=(weakest, float(loads[weakest])),
        )

    def _singular_values(self, posture: Posture) -> np.ndarray:
        return np.linalg.svd(posture.jacobian, compute_uv=False)

    def _dexterity(self, posture: Posture) -> float:
        return float(self._singular_values(posture)[self._rank - 1]) / self._best

    def _axis_dexterity(self, posture: Posture) -> float:
        """Returns the smallest singular value of the Jacobian of position and direction."""
        J = np.vstack([posture.jacobian / self._reach, posture.axis_jacobian])
        rank = min(5, J.shape[1])  # A direction has two degrees of freedom.
        return float(np.linalg.svd(J, compute_uv=False)[rank - 1])

    def _overlaps(self, q: np.ndarray) -> list[Overlap]:
        positions = self._postures.positions(q)
        links = overlaps(self._plant, self._scene_graph, positions)
        return [overlap for overlap in links if overlap.depth > DEEP_M]

    def _ordinary_overlaps(self) -> set[tuple[str, str]]:
        """Returns the pairs of links that overlap in nearly all configurations."""
        sample = self._samples[:: SAMPLES // 32]
        counts = Counter(o.links for q in sample for o in self._overlaps(q))
        return {links for links, count in counts.items() if count > ALWAYS * len(sample)}

    def _deepest(self, q: np.ndarray, ordinary: set[tuple[str, str]]) -> Overlap | None:
        others = [overlap for overlap in self._overlaps(q) if overlap.links not in ordinary]
        return max(others, key=lambda overlap: overlap.depth, default=None)


def _lack(value: float, enough: float) -> float:
    """Returns how far a value is below one that is enough, relative to it."""
    return max(0.0, 1 - float(value) / enough)

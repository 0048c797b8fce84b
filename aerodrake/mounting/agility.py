"""Agility of an arm's tool: the largest velocity and acceleration that joints give it."""

import math
from collections.abc import Iterator

import numpy as np

from aerodrake.mounting.joint import Limits
from aerodrake.mounting.scenario_yaml import AMPLITUDE_M, LAP_S

RANK = 1e-3
"""Singular value over the largest that counts as zero."""
RATE = 2 * math.pi / LAP_S
NEEDED = {
    "velocity": (2 * AMPLITUDE_M * RATE, "m/s"),
    "acceleration": (5 * AMPLITUDE_M * RATE**2, "m/s^2"),
}
"""Largest velocity and acceleration of the proposed clover r = a cos(2 theta), and their units. The
first is at its centre, the second at the tips of its petals."""


def attained(jacobian: np.ndarray, limits: np.ndarray) -> float:
    """Returns the tool's attainable rate in the weakest of its horizontal principal directions.

    Directions in which the joints do not move the tool are left out; the base does.

    Args:
        jacobian: (3, n) m/rad, of the tool's position.
        limits: (n,) limits of the joints' velocities or accelerations.
    """
    directions, values, _ = np.linalg.svd(jacobian[:2])
    moved = directions.T[: len(values)][values > RANK * values[0]]
    return float((np.abs(moved @ jacobian[:2]) @ limits).min())


def cautions(jacobian: np.ndarray, limits: list[Limits]) -> Iterator[str]:
    """Yields a caution for each kind of limits that is too small for the proposed clover.

    Args:
        jacobian: (3, n) m/rad, of the tool's position in the working configuration.
        limits: Limits of the n joints.
    """
    for kind, (needed, unit) in NEEDED.items():
        most = attained(jacobian, np.array([getattr(limit, kind) for limit in limits]))
        if most < needed:
            yield (
                f"caution: limits of joint {kind} give the tool {most:.2g} {unit} in its weakest "
                f"horizontal direction, the reference has up to {needed:.2g}: the base moves it "
                "instead, and pushes and noise move it further"
            )

"""Condensed program of one tick of the MPC."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from aerodrake.model.qp.quadratic_program import QuadraticProgram, violations

MARGIN = 1e-6
"""Margin of widened bounds."""

LEAST_SLACK = 0.03
"""Least range of a slack: a small one would make the program ill-conditioned."""

LEAST_EFFECT = 1e-9
"""Norm of a row below which it is rounding error."""

INPUT_COST = 1e-5
"""Cost of the inputs beside that of violations, which makes the solution unique."""


@dataclass(frozen=True)
class MpcProgram(QuadraticProgram):
    """Condensed program of one tick.

    z (m N,) stacks the scaled inputs axis by axis, the stages of the first axis first.

    Attributes:
        free_response: (F, N), outputs of the stages with zero inputs.
        v_d: (m,) m/s and rad/s, current velocities of the setpoints.
    """

    free_response: np.ndarray
    v_d: np.ndarray

    def with_cost(self, L: np.ndarray, error: np.ndarray, weight: np.ndarray) -> Self:
        """Returns the program with half of | L z + error |^2 W added to its cost.

        Args:
            L: (k, m N).
            error: (k,), its value at z = 0.
            weight: (k,), diagonal of W.
        """
        weighted = L.T * weight
        return replace(self, H=self.H + weighted @ L, g=self.g + weighted @ error)

    def with_rows(self, L: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Self:
        """Returns the program with the constraint lower <= L z <= upper added as its last rows.

        Args:
            L: (k, m N).
            lower, upper: (k,).
        """
        norms = np.linalg.norm(L, axis=1)
        has_effect = norms > LEAST_EFFECT  # A row without effect is infeasible or redundant.
        L, norms = np.where(has_effect[:, None], L, 0.0), np.where(has_effect, norms, 1.0)
        return replace(
            self,
            A=np.vstack([self.A, L / norms[:, None]]),
            lower=np.concatenate([self.lower, lower / norms]),
            upper=np.concatenate([self.upper, upper / norms]),
        )

    def admitting(self, z: np.ndarray, rows: slice = slice(None)) -> Self:
        """Returns the program with the bounds of some rows widened so far that z is feasible.

        Args:
            z: (m N,).
            rows: Rows that may be widened.
        """
        lower, upper, values = self.lower.copy(), self.upper.copy(), self.A @ z
        lower[rows] = np.minimum(lower[rows], values[rows] - MARGIN)
        upper[rows] = np.maximum(upper[rows], values[rows] + MARGIN)
        return replace(self, lower=lower, upper=upper)

    def least_violation(self, hard: int, z: np.ndarray) -> QuadraticProgram:
        """Returns the program of the least sum of squared violations of the last rows.

        The rows that z violates get a slack, which follows the m N inputs in the variables.

        Args:
            hard: Number of rows without slack, which come first.
            z: (m N,), satisfies the hard rows.
        """
        violation = violations(self.A @ z, self.lower, self.upper)
        soft = np.flatnonzero(violation > 0)
        soft = soft[soft >= hard]
        slack = np.maximum(1.01 * violation[soft], LEAST_SLACK)
        by_slack = np.zeros((len(self.A), len(soft)))
        by_slack[soft, np.arange(len(soft))] = slack
        norms = np.ones(len(self.A))
        norms[soft] = np.hypot(1.0, slack)
        costs = np.concatenate([np.full(len(self.g), INPUT_COST), slack**2])
        return QuadraticProgram(
            H=np.diag(costs),
            g=np.zeros(len(costs)),
            A=np.hstack([self.A, by_slack]) / norms[:, None],
            lower=self.lower / norms,
            upper=self.upper / norms,
        )

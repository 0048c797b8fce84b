"""Condensed program of one tick of the MPC."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.linalg import block_diag

from aerodrake.model.qp.quadratic_program import QuadraticProgram

SLACK_COST = 1e3
"""Cost of the squared slack of a softened row, relative to the mean diagonal element of H."""

LEAST_SLACK = 0.03
"""Least range of the slack of a softened row: a small one would make H ill-conditioned."""


@dataclass(frozen=True)
class MpcProgram:
    """Condensed program of one tick, as `QuadraticProgram`.

    z (m N,) stacks the scaled inputs axis by axis, the stages of the first axis first.

    Attributes:
        H, g, A, lower, upper: As in `QuadraticProgram`.
        free_response: (F, N), outputs of the stages with zero inputs.
        v_d: (m,) m/s and rad/s, current velocities of the setpoints.
    """

    H: np.ndarray
    g: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    free_response: np.ndarray
    v_d: np.ndarray

    @property
    def qp(self) -> QuadraticProgram:
        """The program as a solver receives it."""
        return QuadraticProgram(self.H, self.g, self.A, self.lower, self.upper)

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
        norms[norms == 0] = 1.0  # A row without effect is infeasible or redundant.
        return replace(
            self,
            A=np.vstack([self.A, L / norms[:, None]]),
            lower=np.concatenate([self.lower, lower / norms]),
            upper=np.concatenate([self.upper, upper / norms]),
        )

    def softened(self, hard: int, z: np.ndarray) -> QuadraticProgram:
        """Returns the program with slack in rows that a feasible z violates.

        The slack of a row is a further variable at the end of z, whose square has a high cost.

        Args:
            hard: Number of rows without slack, which come first.
            z: (m N,), satisfies the hard rows.
        """
        rows = self.A @ z
        violation = np.maximum(rows - self.upper, self.lower - rows)
        soft = np.flatnonzero(violation > 0)
        soft = soft[soft >= hard]
        slack = np.maximum(1.01 * violation[soft], LEAST_SLACK)
        by_slack = np.zeros((len(self.A), len(soft)))
        by_slack[soft, np.arange(len(soft))] = slack
        norms = np.ones(len(self.A))
        norms[soft] = np.hypot(1.0, slack)
        weight = SLACK_COST * np.diag(self.H).mean() * slack**2
        return QuadraticProgram(
            H=np.ascontiguousarray(block_diag(self.H, np.diag(weight))),
            g=np.concatenate([self.g, np.zeros(len(soft))]),
            A=np.hstack([self.A, by_slack]) / norms[:, None],
            lower=self.lower / norms,
            upper=self.upper / norms,
        )

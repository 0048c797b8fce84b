"""Exact minimiser of a condensed program, with its optimality residual."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

REFINEMENTS = 3
"""Number of iterative refinement steps of the equalities."""


@dataclass(frozen=True)
class Optimum:
    """A minimiser.

    Attributes:
        z: (nz,).
        residual: Largest violation of the optimality conditions: bounds, stationarity
            (relative to the mean diagonal of H), and signs of the multipliers.
        is_constrained: True if a constraint is active.
    """

    z: np.ndarray
    residual: float
    is_constrained: bool


def exact_minimiser(
    H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray, A: np.ndarray
) -> Optimum:
    """Returns z of min z' H z / 2 + g' z subject to |z| <= 1 and lower <= A z <= upper.

    With H = L L' and y = L' z + L^-1 g this is the least |y| subject to G y <= h, solved
    as nonnegative least squares (Lawson and Hanson, Solving Least Squares Problems,
    1974, chapter 23): min |[G'; h'] u + [0; 1]| over the multipliers u >= 0. The active
    constraints are then solved as equalities, with iterative refinement. The algorithm is
    independent of the solvers that it is compared with.

    Args:
        H: (nz, nz), symmetric and positive definite.
        g: (nz,).
        lower, upper: (rows,).
        A: (rows, nz).

    Raises:
        ValueError: if the program is infeasible.
    """
    identity = np.eye(len(g))
    rows = np.vstack([identity, A, -identity, -A])
    ones = np.ones(len(g))
    bound = np.concatenate([ones, upper, ones, -lower])
    rows, bound = rows[np.isfinite(bound)], bound[np.isfinite(bound)]
    scale = np.diag(H).mean()
    H, g = H / scale, g / scale
    h = bound - rows @ np.linalg.solve(H, -g)
    active = np.zeros(len(h), dtype=bool)
    if (h < 0).any():  # Otherwise y = 0, the unconstrained minimiser, is feasible.
        G = solve_triangular(np.linalg.cholesky(H), rows.T, lower=True).T
        target = np.append(np.zeros(len(g)), -1.0)
        u, distance = nnls(np.vstack([-G.T, h]), target, maxiter=50 * len(h))
        if distance < 1e-9:
            raise ValueError("infeasible: no z is within the bounds")
        active = u > 0
    z, multipliers = _solve_equalities(H, g, rows[active], bound[active])
    stationarity = H @ z + g + rows[active].T @ multipliers
    residual = max(
        np.abs(stationarity).max(),
        (rows @ z - bound).max(initial=0.0),
        np.abs(rows[active] @ z - bound[active]).max(initial=0.0),
        (-multipliers).max(initial=0.0),
    )
    return Optimum(z, float(residual), bool(active.any()))


def _solve_equalities(
    H: np.ndarray, g: np.ndarray, rows: np.ndarray, bound: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns z and the multipliers of min z' H z / 2 + g' z subject to rows z = bound."""
    n, m = len(g), len(bound)
    K = np.block([[H, rows.T], [rows, np.zeros((m, m))]])
    right = np.concatenate([-g, bound])
    solution = np.zeros(n + m)
    for _ in range(REFINEMENTS):
        # Least squares, since multipliers of linearly dependent rows are not unique.
        rest = right - K @ solution
        solution += np.linalg.lstsq(K, rest, rcond=1e-13)[0] if m else np.linalg.solve(K, rest)
    return solution[:n], solution[n:]

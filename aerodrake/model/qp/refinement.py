"""Exact solution of a quadratic program from an approximate one."""

import numpy as np
from scipy.linalg.lapack import dposv, dtrtrs
from scipy.optimize import nnls

from aerodrake.model.qp.quadratic_program import FEASIBILITY, Constraints, QuadraticProgram

DEPENDENT = 1e-9
"""Relative singular value below which active constraints are linearly dependent."""

CORRECTIONS = 5
"""Largest number of corrections of the active set."""


def estimated_active_set(
    constraints: Constraints, z: np.ndarray, multipliers: np.ndarray
) -> np.ndarray:
    """Returns (nc,): 1 where an upper bound is active, -1 a lower one, else 0.

    A bound is active if its multiplier exceeds the distance of z from it (as in the polishing
    of OSQP: Stellato et al. 2020, section 4).

    Args:
        constraints: The constraints of a program.
        z: (nz,), approximate minimiser.
        multipliers: (nc,), approximate Lagrange multipliers over the scale of the cost;
            positive for upper bounds, negative for lower ones.
    """
    values = constraints.N @ z
    is_lower = values - constraints.lower < -multipliers
    is_upper = constraints.upper - values < multipliers
    return is_upper.astype(int) - is_lower


def exact_minimiser(
    program: QuadraticProgram, constraints: Constraints, active: np.ndarray
) -> np.ndarray | None:
    """Returns the minimiser (nz,) if `active` is nearly its active set, else None.

    Solves the program with the active constraints N z = b as equalities, by the Schur
    complement N H^-1 N^T, and verifies that no constraint is violated and no multiplier
    negative. Otherwise the violated constraints join the active ones, those with negative
    multipliers leave, and it is solved again, a few times (primal-dual active set method:
    Hintermueller, Ito and Kunisch 2002, doi 10.1137/S1052623401383558). Active constraints may
    be linearly dependent.

    Args:
        program: A program that has a Cholesky factor.
        constraints: Its constraints.
        active: (nc,): 1 where the upper bound is active, -1 the lower one, else 0.
    """
    for _ in range(CORRECTIONS + 1):
        z, multipliers, is_optimal = _equality_minimiser(program, constraints, active)
        values = constraints.N @ z
        is_above = values - constraints.upper > FEASIBILITY
        is_below = constraints.lower - values > FEASIBILITY
        if is_optimal and not (is_above | is_below).any():
            return z.clip(-1, 1)
        stays = multipliers > -FEASIBILITY * program.scale
        corrected = np.where(stays, active, 0)
        corrected[is_above], corrected[is_below] = 1, -1
        if (corrected == active).all():
            return None
        active = corrected
    return None


def _equality_minimiser(
    program: QuadraticProgram, constraints: Constraints, active: np.ndarray
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Returns z (nz,), its multipliers (nc,), and True if none need be negative."""
    z, indices, multipliers = program.minimiser, np.flatnonzero(active), np.zeros(len(active))
    if not len(indices):
        return z, multipliers, True
    side = active[indices]
    N = side[:, None] * constraints.N[indices]
    b = np.where(side > 0, constraints.upper[indices], -constraints.lower[indices])
    L_inv_N, _ = dtrtrs(program.factor, N.T, lower=1)
    S, violation = L_inv_N.T @ L_inv_N, N @ z - b
    _, of_active, is_singular = dposv(S, violation)
    if is_singular:
        of_active = np.linalg.lstsq(S, violation, rcond=DEPENDENT)[0]
    z = z - dtrtrs(program.factor, L_inv_N @ of_active, lower=1, trans=1)[0]
    is_optimal = bool(of_active.min() >= -FEASIBILITY * program.scale)
    if is_singular and not is_optimal:  # Other multipliers of the same z may be positive.
        is_optimal = _is_in_cone(N, (program.H @ z + program.g) / program.scale)
    multipliers[indices] = of_active
    return z, multipliers, is_optimal


def _is_in_cone(N: np.ndarray, gradient: np.ndarray) -> bool:
    """Returns True if -gradient (nz,) is a nonnegative combination of normals N (k, nz)."""
    return bool(nnls(N.T, -gradient)[1] < FEASIBILITY)


def residual(
    program: QuadraticProgram, constraints: Constraints, z: np.ndarray, multipliers: np.ndarray
) -> float:
    """Returns the largest violation of a bound, or of stationarity over the scale of the cost.

    z and multipliers are as for `estimated_active_set`.
    """
    gradient = (program.H @ z + program.g) / program.scale + constraints.N.T @ multipliers
    return float(max(constraints.violations(z).max(), np.abs(gradient).max()))

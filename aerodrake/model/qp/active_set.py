"""Dual active-set method for strictly convex quadratic programs."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.qp.banded_rows import BandedRows, row_dot, rows_dot
from aerodrake.support.compiled import compiled

TOLERANCE = 1e-9
"""Largest violation of a constraint at the solution."""

ACTIVE_TOLERANCE = 1e-7
"""Largest residual of an active constraint, and largest negative multiplier."""

DEPENDENT = 1e-9
"""Relative squared norm of a constraint normal, after projecting out the active ones, below
which it is linearly dependent on them."""


class FactorisedQp(NamedTuple):
    """min z^T H z / 2 + g^T z subject to |z| <= 1 and lower <= A z <= upper, with H = L L^T.

    Constraint i is z_i for i < nz, and row i - nz of A after that.

    Attributes:
        V: (nz, nz), transpose of L^-1.
        minimiser: (nz,), the unconstrained minimiser.
        A: (rows, nz).
        lower, upper: (rows,); infinite where there is no bound.
    """

    V: np.ndarray
    minimiser: np.ndarray
    A: BandedRows
    lower: np.ndarray
    upper: np.ndarray


class Constraint(NamedTuple):
    """A constraint with outward normal n.

    Attributes:
        index: As in `FactorisedQp`.
        side: 1 for the upper bound, -1 for the lower one.
        L_inv_n, H_inv_n: (nz,).
    """

    index: int
    side: int
    L_inv_n: np.ndarray
    H_inv_n: np.ndarray


class ActiveSet(NamedTuple):
    """Storage for up to nz active constraints; only the first k entries are in use.

    Attributes:
        index, side: (nz,), of each constraint.
        multiplier: (nz,), Lagrange multiplier of each.
        L_inv_n, H_inv_n: (nz, nz), a row for each.
        S: (nz, nz), Gram matrix of the rows of `L_inv_n`.
        C: (nz, nz), lower Cholesky factor of S.
    """

    index: np.ndarray
    side: np.ndarray
    multiplier: np.ndarray
    L_inv_n: np.ndarray
    H_inv_n: np.ndarray
    S: np.ndarray
    C: np.ndarray


class ActiveSetSolution(NamedTuple):
    """Result of `solve_active_set`.

    Attributes:
        is_optimal: True if the optimality conditions were verified.
        z: (nz,), the minimiser; the unconstrained one if `is_optimal` is False.
        active: (nz + rows,), 1 where the upper bound is active, -1 the lower one, else 0.
    """

    is_optimal: bool
    z: np.ndarray
    active: np.ndarray


@compiled
def solve_active_set(qp: FactorisedQp, guess: np.ndarray, max_exchanges: int) -> ActiveSetSolution:
    """Solves a program by the dual active-set method of Goldfarb and Idnani (1983).

    Starts from the guessed active set without the constraints whose multipliers are negative.
    Then adds the most violated constraint, dropping those whose multipliers reach zero, until
    none is violated. z minimises the Lagrangian throughout. At the end, primal feasibility,
    complementarity and the signs of the multipliers are verified.

    Args:
        qp: The program.
        guess: (nz + rows,), as `ActiveSetSolution.active`.
        max_exchanges: Largest number of constraints that are added. The method also stops,
            without a solution, if the constraints are infeasible.
    """
    nz = len(qp.minimiser)
    active, k = _make_active_set(nz), 0
    for index in np.flatnonzero(guess):
        side = guess[index]
        if k < nz and np.isfinite(_violation(qp, index, side, qp.minimiser)):
            k = _add(active, k, _make_constraint(qp, index, side), 0.0)
    k = _drop_negative(active, k, qp)

    for _ in range(max_exchanges):
        z = _minimiser(active, k, qp.minimiser)
        index, side, violation = _most_violated(qp, z)
        if violation <= TOLERANCE:
            sides = np.zeros(len(guess), dtype=np.int64)
            for j in range(k):
                sides[active.index[j]] = active.side[j]
            return ActiveSetSolution(_is_complementary(active, k, qp, z), z, sides)
        k = _exchange(active, k, _make_constraint(qp, index, side), violation)
        if k < 0:
            break
    return ActiveSetSolution(False, qp.minimiser, guess)


@compiled
def _make_active_set(nz: int) -> ActiveSet:
    index, square = np.empty(nz, dtype=np.int64), np.empty((nz, nz))
    squares = square, square.copy(), square.copy(), square.copy()
    return ActiveSet(index, index.copy(), np.empty(nz), *squares)


@compiled
def _is_complementary(active: ActiveSet, k: int, qp: FactorisedQp, z: np.ndarray) -> bool:
    """Returns True if active constraints are equalities at z and no multiplier is negative."""
    for j in range(k):
        residual = _violation(qp, active.index[j], active.side[j], z)
        if not (abs(residual) < ACTIVE_TOLERANCE and active.multiplier[j] > -ACTIVE_TOLERANCE):
            return False
    return True


@compiled
def _exchange(active: ActiveSet, k: int, constraint: Constraint, violation: float) -> int:
    """Adds a violated constraint, dropping those whose multipliers reach zero on the way.

    Returns:
        The number of active constraints; -1 if the constraints are infeasible.
    """
    norm2, multiplier = constraint.L_inv_n @ constraint.L_inv_n, 0.0
    while True:
        overlap = np.empty(k)
        for j in range(k):
            overlap[j] = active.L_inv_n[j] @ constraint.L_inv_n
        # Decrease of the active multipliers per increase of the new one.
        decrease = _solve_cholesky(active.C, overlap, k)
        projected = norm2 - overlap @ decrease
        step, blocking = np.inf, -1
        if projected > DEPENDENT * norm2 and k < len(constraint.L_inv_n):
            step = violation / projected
        for j in range(k):
            if decrease[j] > 0 and active.multiplier[j] < step * decrease[j]:
                step, blocking = active.multiplier[j] / decrease[j], j
        if not np.isfinite(step):
            return -1
        active.multiplier[:k] -= step * decrease
        multiplier += step
        violation -= step * projected
        if blocking < 0:
            return _add(active, k, constraint, multiplier)
        k = _drop(active, k, blocking)


@compiled
def _drop_negative(active: ActiveSet, k: int, qp: FactorisedQp) -> int:
    """Computes the multipliers, dropping the most negative one until none is; returns k."""
    while k > 0:
        violation = np.empty(k)
        for j in range(k):
            violation[j] = _violation(qp, active.index[j], active.side[j], qp.minimiser)
        active.multiplier[:k] = _solve_cholesky(active.C, violation, k)
        least = np.argmin(active.multiplier[:k])
        if active.multiplier[least] >= 0:
            break
        k = _drop(active, k, least)
    return k


@compiled
def _add(active: ActiveSet, k: int, constraint: Constraint, multiplier: float) -> int:
    """Adds a constraint unless it is linearly dependent on the active ones; returns k."""
    active.index[k], active.side[k] = constraint.index, constraint.side
    active.multiplier[k] = multiplier
    active.L_inv_n[k], active.H_inv_n[k] = constraint.L_inv_n, constraint.H_inv_n
    for j in range(k + 1):
        active.S[k, j] = active.S[j, k] = active.L_inv_n[j] @ constraint.L_inv_n
    return k + 1 if _factorise(active.S, active.C, k, k + 1) else k


@compiled
def _drop(active: ActiveSet, k: int, j: int) -> int:
    """Drops the j-th active constraint; returns k."""
    for i in range(j, k - 1):
        active.index[i], active.side[i] = active.index[i + 1], active.side[i + 1]
        active.multiplier[i] = active.multiplier[i + 1]
        active.L_inv_n[i], active.H_inv_n[i] = active.L_inv_n[i + 1], active.H_inv_n[i + 1]
        active.S[i, :k] = active.S[i + 1, :k]
    for i in range(j, k - 1):
        active.S[:k, i] = active.S[:k, i + 1]
    _factorise(active.S, active.C, j, k - 1)
    return k - 1


@compiled
def _factorise(S: np.ndarray, C: np.ndarray, first: int, k: int) -> bool:
    """Computes rows `first` to k of C, with C C^T = S; returns False if S is singular."""
    for i in range(first, k):
        for j in range(i):
            C[i, j] = (S[i, j] - C[i, :j] @ C[j, :j]) / C[j, j]
        pivot = S[i, i] - C[i, :i] @ C[i, :i]
        if not pivot > DEPENDENT * S[i, i]:
            return False
        C[i, i] = np.sqrt(pivot)
    return True


@compiled
def _solve_cholesky(C: np.ndarray, b: np.ndarray, k: int) -> np.ndarray:
    """Returns x (k,), with C C^T x = b (k,)."""
    x = b.copy()
    for i in range(k):
        x[i] = (x[i] - C[i, :i] @ x[:i]) / C[i, i]
    for i in range(k - 1, -1, -1):
        x[i] /= C[i, i]
        for j in range(i):
            x[j] -= x[i] * C[i, j]
    return x


@compiled
def _make_constraint(qp: FactorisedQp, index: int, side: int) -> Constraint:
    """Returns a constraint with its normal in the metrics of L and H."""
    nz = len(qp.V)
    if index < nz:
        L_inv_n = side * qp.V[index]
    else:
        L_inv_n, row = np.zeros(nz), index - nz
        for i in range(qp.A.band.shape[1]):
            L_inv_n += (side * qp.A.band[row, i]) * qp.V[qp.A.start[row] + i]
    return Constraint(index, side, L_inv_n, qp.V @ L_inv_n)


@compiled
def _minimiser(active: ActiveSet, k: int, unconstrained: np.ndarray) -> np.ndarray:
    """Returns the minimiser (nz,) of the Lagrangian at the current multipliers."""
    z = unconstrained.copy()
    for j in range(k):
        for i in range(len(z)):
            z[i] -= active.multiplier[j] * active.H_inv_n[j, i]
    return z


@compiled
def _violation(qp: FactorisedQp, index: int, side: int, z: np.ndarray) -> float:
    """Returns n z - b of a constraint n z <= b."""
    row = index - len(z)
    if row < 0:
        return side * z[index] - 1.0
    value = row_dot(qp.A, row, z)
    return value - qp.upper[row] if side > 0 else qp.lower[row] - value


@compiled
def _most_violated(qp: FactorisedQp, z: np.ndarray) -> tuple[int, int, float]:
    """Returns (index, side, violation) of the most violated constraint at z (nz,)."""
    lower, upper, Az = qp.lower, qp.upper, rows_dot(qp.A, z)
    index, side, most = -1, 0, -np.inf
    for i in range(len(z)):
        if abs(z[i]) - 1.0 > most:
            index, side, most = i, 1 if z[i] > 0 else -1, abs(z[i]) - 1.0
    for i in range(len(Az)):
        if Az[i] - upper[i] > most:
            index, side, most = len(z) + i, 1, Az[i] - upper[i]
        if lower[i] - Az[i] > most:
            index, side, most = len(z) + i, -1, lower[i] - Az[i]
    return index, side, most

"""Exact solution of a quadratic program by exchanging active bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.qp.banded_rows import BandedRows, row_dot, rows_dot
from aerodrake.support.compiled import compiled

TOLERANCE = 1e-9
"""By how much the solution may be beyond a bound."""

MET = 1e-7
"""By how much it may be off a bound that is active, and a price below zero."""

DEPENDENT = 1e-9
"""What of a bound's influence others leave of it, of all, if they imply it."""


class Held(NamedTuple):
    """Bounds n z <= b that are held, in the order in which they were taken in.

    Attributes:
        row: (nz,) which, of those of z first.
        side: (nz,) 1 where it is the upper bound, -1 where the lower one.
        price: (nz,) multiplier of each.
        half: (nz, nz), L^-1 n of each, L L' = H.
        push: (nz, nz), H^-1 n of each.
        S: (nz, nz), half half', and
        C: (nz, nz), its lower Cholesky factor.
    """

    row: np.ndarray
    side: np.ndarray
    price: np.ndarray
    half: np.ndarray
    push: np.ndarray
    S: np.ndarray
    C: np.ndarray


@compiled
def exchange_active_set(
    V: np.ndarray,
    free: np.ndarray,
    A: BandedRows,
    lower: np.ndarray,
    upper: np.ndarray,
    guess: np.ndarray,
    most: int,
) -> tuple[bool, np.ndarray, np.ndarray]:
    """The minimiser of z' H z / 2 + g' z with |z| <= 1 and lower <= A z <= upper.

    The dual active set method (Goldfarb and Idnani 1983), from a guess: those of its bounds
    are held that have a price. Then the one that is violated most is taken in, and those
    are let go that this makes worthless, until none is violated. z is always the minimiser
    at the prices of what is held; in the end it is checked that no bound is exceeded, and
    that what is held is met and has no negative price: then z is the solution.

    Args:
        V: (nz, nz), the transpose of L^-1, with H = L L'.
        free: (nz,), the unconstrained minimiser.
        A: (rows, nz), banded.
        lower, upper: (rows,); infinite where there is no bound.
        guess: (nz + rows,), of z first: 1 at its upper bound, -1 at its lower one, else 0.
        most: How many exchanges are tried.

    Returns:
        Whether it was found; z (nz,); and the bounds that are active there, as `guess`.
        It is not found where bounds contradict each other.
    """
    nz = len(free)
    empty = np.empty((nz, nz))
    held = Held(
        np.empty(nz, dtype=np.int64),
        np.empty(nz, dtype=np.int64),
        np.empty(nz),
        empty,
        empty.copy(),
        empty.copy(),
        empty.copy(),
    )
    k = 0
    for row in np.flatnonzero(guess):
        if k < nz and np.isfinite(_excess(row, guess[row], free, A, lower, upper)):
            half, push = _influence(V, A, row, guess[row])
            k = _take_in(held, k, row, guess[row], half, push, 0.0)
    k = _let_go_of_worthless(held, k, free, A, lower, upper)

    for _ in range(most):
        z = _minimiser(held, k, free)
        row, side, excess = _most_violated(z, rows_dot(A, z), lower, upper)
        if excess <= TOLERANCE:
            active = np.zeros(len(guess), dtype=np.int64)
            is_met = True
            for j in range(k):
                active[held.row[j]] = held.side[j]
                excess = _excess(held.row[j], held.side[j], z, A, lower, upper)
                is_met = is_met and abs(excess) < MET and held.price[j] > -MET
            return is_met, z, active
        half, push = _influence(V, A, row, side)
        k = _exchange(held, k, row, side, excess, half, push)
        if k < 0:
            break
    return False, free, guess


@compiled
def _exchange(
    held: Held, k: int, row: int, side: int, excess: float, half: np.ndarray, push: np.ndarray
) -> int:
    """Takes in a bound exceeded by `excess`; how many are held then, -1 if nothing gives way."""
    whole, paid = half @ half, 0.0
    while True:
        overlap = np.empty(k)
        for j in range(k):
            overlap[j] = held.half[j] @ half
        give = _solved(held.C, overlap, k)  # How prices fall as that of the new bound rises.
        left = whole - overlap @ give
        step, first = np.inf, -1
        if left > DEPENDENT * whole and k < len(half):
            step = excess / left
        for j in range(k):
            if give[j] > 0 and held.price[j] < step * give[j]:
                step, first = held.price[j] / give[j], j
        if not np.isfinite(step):
            return -1
        held.price[:k] -= step * give
        paid += step
        excess -= step * left
        if first < 0:
            return _take_in(held, k, row, side, half, push, paid)
        k = _let_go(held, k, first)


@compiled
def _let_go_of_worthless(
    held: Held, k: int, free: np.ndarray, A: BandedRows, lower: np.ndarray, upper: np.ndarray
) -> int:
    """Prices what is held, less those that would rather be let go; how many are left."""
    while k > 0:
        excess = np.empty(k)
        for j in range(k):
            excess[j] = _excess(held.row[j], held.side[j], free, A, lower, upper)
        held.price[:k] = _solved(held.C, excess, k)
        cheapest = np.argmin(held.price[:k])
        if held.price[cheapest] >= 0:
            break
        k = _let_go(held, k, cheapest)
    return k


@compiled
def _take_in(
    held: Held, k: int, row: int, side: int, half: np.ndarray, push: np.ndarray, price: float
) -> int:
    """Holds one more bound, unless others imply it; how many are held then."""
    held.row[k], held.side[k], held.price[k] = row, side, price
    held.half[k], held.push[k] = half, push
    for j in range(k + 1):
        held.S[k, j] = held.S[j, k] = held.half[j] @ half
    return k + 1 if _factorise(held.S, held.C, k, k + 1) else k


@compiled
def _let_go(held: Held, k: int, j: int) -> int:
    """Holds the j-th bound no longer; how many are held then."""
    for i in range(j, k - 1):
        held.row[i], held.side[i] = held.row[i + 1], held.side[i + 1]
        held.price[i] = held.price[i + 1]
        held.half[i], held.push[i] = held.half[i + 1], held.push[i + 1]
        held.S[i, :k] = held.S[i + 1, :k]
    for i in range(j, k - 1):
        held.S[:k, i] = held.S[:k, i + 1]
    _factorise(held.S, held.C, j, k - 1)
    return k - 1


@compiled
def _factorise(S: np.ndarray, C: np.ndarray, first: int, k: int) -> bool:
    """The rows from `first` to k of C, C C' = S; whether none depends on those before it."""
    for i in range(first, k):
        for j in range(i):
            C[i, j] = (S[i, j] - C[i, :j] @ C[j, :j]) / C[j, j]
        left = S[i, i] - C[i, :i] @ C[i, :i]
        if not left > DEPENDENT * S[i, i]:
            return False
        C[i, i] = np.sqrt(left)
    return True


@compiled
def _solved(C: np.ndarray, b: np.ndarray, k: int) -> np.ndarray:
    """(k,) x of C C' x = b (k,)."""
    x = b.copy()
    for i in range(k):
        x[i] = (x[i] - C[i, :i] @ x[:i]) / C[i, i]
    for i in range(k - 1, -1, -1):
        x[i] /= C[i, i]
        for j in range(i):
            x[j] -= x[i] * C[i, j]
    return x


@compiled
def _influence(V: np.ndarray, A: BandedRows, row: int, side: int) -> tuple[np.ndarray, np.ndarray]:
    """(L^-1 n, H^-1 n), each (nz,), of a bound's outward normal n."""
    nz = len(V)
    if row < nz:
        half = side * V[row]
    else:
        half = np.zeros(nz)
        for i in range(A.band.shape[1]):
            half += (side * A.band[row - nz, i]) * V[A.start[row - nz] + i]
    return half, V @ half


@compiled
def _minimiser(held: Held, k: int, free: np.ndarray) -> np.ndarray:
    """(nz,) z, at the prices of what is held."""
    z = free.copy()
    for j in range(k):
        for i in range(len(z)):
            z[i] -= held.price[j] * held.push[j, i]
    return z


@compiled
def _excess(
    row: int, side: int, z: np.ndarray, A: BandedRows, lower: np.ndarray, upper: np.ndarray
) -> float:
    """n z - b: by how much z is beyond a bound."""
    i = row - len(z)
    if i < 0:
        return side * z[row] - 1.0
    return row_dot(A, i, z) - upper[i] if side > 0 else lower[i] - row_dot(A, i, z)


@compiled
def _most_violated(
    z: np.ndarray, of_rows: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[int, int, float]:
    """(row, side, excess) of the bound that z or of_rows = A z exceeds most."""
    row, side, most = -1, 0, -np.inf
    for i in range(len(z)):
        if abs(z[i]) - 1.0 > most:
            row, side, most = i, 1 if z[i] > 0 else -1, abs(z[i]) - 1.0
    for i in range(len(of_rows)):
        if of_rows[i] - upper[i] > most:
            row, side, most = len(z) + i, 1, of_rows[i] - upper[i]
        if lower[i] - of_rows[i] > most:
            row, side, most = len(z) + i, -1, lower[i] - of_rows[i]
    return row, side, most

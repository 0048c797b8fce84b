"""Costs and constraints of one's own on quantities that the MPC predicts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from aerodrake.model.mpc.objective import CostTerm
from aerodrake.model.mpc.predictions import QUANTITIES, quantity_size
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.support.errors import BadInput, nearest


@dataclass(frozen=True, kw_only=True)
class CustomTerm:
    """Values M x_k of a predicted quantity x at some stages.

    Attributes:
        quantity: A key of `QUANTITIES`.
        name: Name in messages and in the printed program.
        matrix: M (d, size of the quantity); None for the identity.
        stages: Numbers from 1 to N; None for all.
    """

    quantity: str
    name: str
    matrix: ArrayLike | None = None
    stages: Sequence[int] | None = None

    def selection(self, joints: int, horizon: int) -> tuple[np.ndarray, np.ndarray]:
        """Returns M (d, size) and the stages (S,), for n `joints` and N stages.

        Raises:
            BadInput: if the quantity, the shape of M or a stage does not exist.
        """
        if self.quantity not in QUANTITIES:
            self._refuse("quantity", f"got '{self.quantity}'; {nearest(self.quantity, QUANTITIES)}")
        size = quantity_size(self.quantity, joints)
        M = np.eye(size) if self.matrix is None else self._array("matrix", self.matrix)
        if M.ndim != 2 or M.shape[1] != size:
            self._refuse("matrix", f"expected shape (d, {size}), got {M.shape}")
        every = range(1, horizon + 1)
        stages = np.array(every if self.stages is None else list(self.stages), dtype=object)
        if not len(stages) or any(stage not in every for stage in stages):
            self._refuse("stages", f"expected integers from 1 to {horizon}, got {self.stages}")
        return M, stages.astype(int)

    def vector(self, key: str, size: int, allows_infinite: bool = False) -> np.ndarray:
        """Returns an attribute as an array (size,); a single number counts for all entries.

        Raises:
            BadInput: if it has another length, or an entry is not a number.
        """
        value = self._array(key, getattr(self, key), allows_infinite)
        if value.shape not in ((), (1,), (size,)):
            self._refuse(key, f"expected one number or {size}, got shape {value.shape}")
        return np.broadcast_to(value, size)

    def _array(self, key: str, value: ArrayLike, allows_infinite: bool = False) -> np.ndarray:
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            self._refuse(key, f"expected numbers, got {value!r}")
        if np.isnan(array).any() or not (allows_infinite or np.isfinite(array).all()):
            self._refuse(key, f"expected {'no NaN' if allows_infinite else 'finite numbers'}")
        return array

    def _refuse(self, key: str, message: str) -> None:
        raise BadInput(f"{type(self).__name__} '{self.name}'", key, message)


@dataclass(frozen=True, kw_only=True)
class CustomCost(CustomTerm):
    """Cost | M x_k - desired |^2 W at the chosen stages, times the ticks that each lasts.

    Attributes:
        weight: W's diagonal (d,), or one number; not negative.
        desired: (d,), or one number.
    """

    weight: ArrayLike = 1.0
    desired: ArrayLike = 0.0

    def term(self, M: np.ndarray) -> CostTerm:
        """Returns the term with M (d, size).

        Raises:
            BadInput: if `weight` or `desired` do not fit.
        """
        d = len(M)
        weight = self.vector("weight", d)
        if (weight < 0).any():
            self._refuse("weight", "expected 0 or more")
        desired = self.vector("desired", d)[:, None]
        formula = f"| M {self.quantity} - desired |^2 W"
        return CostTerm(self.name, formula, ((self.quantity, M),), desired, weight)


@dataclass(frozen=True, kw_only=True)
class CustomConstraint(CustomTerm):
    """Constraint lower <= M x_k <= upper at the chosen stages.

    Where it cannot be satisfied it is softened: then the sum of squared violations is
    minimised, and the tick's status is `SOFTENED`.

    Attributes:
        lower, upper: (d,), or one number; infinite for no bound.
    """

    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf

    def bounds(self, d: int) -> tuple[np.ndarray, np.ndarray]:
        """Returns (lower, upper), (d,) each.

        Raises:
            BadInput: if they do not fit, or a lower bound exceeds its upper one.
        """
        lower, upper = (self.vector(key, d, allows_infinite=True) for key in ("lower", "upper"))
        if (lower > upper).any():
            self._refuse("lower", "expected no more than upper")
        return lower, upper


class StagesCost(NamedTuple):
    """A cost term at some stages (S,), from 1 to N."""

    term: CostTerm
    stages: np.ndarray


class StagesConstraint(NamedTuple):
    """lower <= M x_k <= upper of a quantity x at some stages (S,), from 1 to N."""

    name: str
    quantity: str
    M: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    stages: np.ndarray


class CustomTerms:
    """The custom costs and constraints of a formulation.

    Attributes:
        terms: As given.
        costs, constraints: The same, with all arrays in their final shapes.

    Args:
        terms: Costs and constraints.
        joints: n.
        ticks: (N,), duration of each stage.

    Raises:
        BadInput: if a term does not fit.
    """

    def __init__(self, terms: Sequence[CustomTerm], joints: int, ticks: np.ndarray):
        self.terms, self._ticks = tuple(terms), ticks
        self.costs: list[StagesCost] = []
        self.constraints: list[StagesConstraint] = []
        for term in terms:
            M, stages = term.selection(joints, len(ticks))
            if isinstance(term, CustomCost):
                self.costs.append(StagesCost(term.term(M), stages))
            else:
                bounds = term.bounds(len(M))
                self.constraints.append(
                    StagesConstraint(term.name, term.quantity, M, *bounds, stages)
                )

    def added_to(
        self, program: MpcProgram, predict: Callable[[str], tuple[np.ndarray, np.ndarray]]
    ) -> MpcProgram:
        """Returns a program with the terms.

        Args:
            program: Program of one tick.
            predict: Returns L (N, size, m N) and x_0 (N, size) of a quantity x = L z + x_0.
        """
        for term, stages in self.costs:
            ((quantity, M),) = term.parts
            L, x = predict(quantity)
            L, error = M @ L[stages - 1], x[stages - 1] @ M.T - term.desired.T
            weight = np.multiply.outer(self._ticks[stages - 1], term.weight)
            program = program.with_cost(L.reshape(-1, L.shape[-1]), error.ravel(), weight.ravel())
        for _, quantity, M, lower, upper, stages in self.constraints:
            L, x = predict(quantity)
            L, x = M @ L[stages - 1], x[stages - 1] @ M.T
            bounds = ((bound - x).ravel() for bound in (lower, upper))
            program = program.with_rows(L.reshape(-1, L.shape[-1]), *bounds)
        return program

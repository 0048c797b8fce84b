"""Custom costs and constraints on quantities that the MPC predicts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from aerodrake.model.mpc.condensing import Condensing, rows_by_input
from aerodrake.model.mpc.objective import CostTerm, combined
from aerodrake.model.mpc.predictions import QUANTITIES, RATES, StagePredictions, quantity_size
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.support.errors import BadInput, nearest


@dataclass(frozen=True, kw_only=True)
class CustomTerm:
    """Values M x of a predicted quantity x in some stages.

    Attributes:
        quantity: A key of `QUANTITIES`.
        name: Name in messages and in the printed program.
        matrix: M (d, size of the quantity); None for the identity.
        stages: Numbers from 1 to N; None for all. Stage k ends at x_k; its input is u_{k-1}.
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
        if not isinstance(self.quantity, str) or self.quantity not in QUANTITIES:
            self._refuse("quantity", f"got '{self.quantity}'; {nearest(self.quantity, QUANTITIES)}")
        size = quantity_size(self.quantity, joints)
        M = np.eye(size) if self.matrix is None else self._array("matrix", self.matrix)
        if M.ndim != 2 or M.shape[1] != size:
            self._refuse("matrix", f"expected shape (d, {size}), got {M.shape}")
        every = np.arange(1, horizon + 1)
        try:
            stages = every if self.stages is None else np.array([*self.stages])
        except (TypeError, ValueError):  # No sequence, or a ragged one.
            stages = np.zeros(0)
        if stages.ndim != 1 or stages.dtype.kind not in "iu" or not np.isin(stages, every).all():
            self._refuse("stages", f"expected integers from 1 to {horizon}, got {self.stages}")
        return M, stages

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
    """Cost | M x - desired |^2 W at the end of each chosen stage, times the ticks that it lasts.

    Attributes:
        weight: W's diagonal (d,), or one number; from 0 to 1e9.
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
        if (weight < 0).any() or (weight > 1e9).any():
            self._refuse("weight", "expected 0 to 1e9")
        desired = self.vector("desired", d)[:, None]
        formula = f"| M {self.quantity} - desired |^2 W"
        return CostTerm(self.name, formula, ((self.quantity, M),), desired, weight)


@dataclass(frozen=True, kw_only=True)
class CustomConstraint(CustomTerm):
    """Constraint lower <= M (x + tau x') <= upper at the end of each chosen stage.

    With the rate x', x approaches its bound no faster than as exp(-t / tau), and hence stays
    within. With tau = 0 the predicted x may reach the bound at full speed; delays that the model
    does not contain, such as the arm's, then carry the vehicle beyond. Quantities without an
    entry in `RATES` have no x'; their bounds are on x.

    A constraint that cannot be satisfied is softened: the sum of squared violations is minimised
    before the cost, and the tick's status is `SOFTENED`.

    Attributes:
        lower, upper: (d,), or one number; infinite for no bound.
        time_constant_s: tau.
    """

    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf
    time_constant_s: float = 0.1

    def at(self, M: np.ndarray, stages: np.ndarray) -> "ConstraintAtStages":
        """Returns the constraint with M (d, size) and stages (S,).

        Raises:
            BadInput: if bounds or time constant do not fit, or a lower bound exceeds its upper one.
        """
        lower, upper = (self.vector(key, len(M), True) for key in ("lower", "upper"))
        if (lower > upper).any():
            self._refuse("lower", "expected no more than upper")
        for key, bound, none in (("lower", lower, -np.inf), ("upper", upper, np.inf)):
            if (bound == -none).any():
                self._refuse(key, f"expected numbers, or {none} for no bound")
        (tau,) = self.vector("time_constant_s", 1)
        if not 0 <= tau <= 10:
            self._refuse("time_constant_s", f"expected 0 to 10 s, got {tau}")
        parts: tuple[tuple[str, np.ndarray], ...] = ((self.quantity, M),)
        formula = f"M {self.quantity}"
        if tau > 0 and self.quantity in RATES:
            parts = (*parts, (RATES[self.quantity], tau * M))
            formula = f"M ({self.quantity} + {tau:g} s x {RATES[self.quantity]})"
        return ConstraintAtStages(self.name, formula, parts, lower, upper, stages)


class CostAtStages(NamedTuple):
    """A cost term at the ends of some stages (S,), from 1 to N."""

    term: CostTerm
    stages: np.ndarray


class ConstraintAtStages(NamedTuple):
    """lower <= sum_i M_i x_i <= upper of quantities x_i at the ends of stages (S,), from 1 to N.

    Attributes:
        name, formula: For the printed program.
        parts: (quantity, M_i (d, size)) of each quantity.
        lower, upper: (d,).
        stages: (S,).
    """

    name: str
    formula: str
    parts: tuple[tuple[str, np.ndarray], ...]
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
        self.costs: list[CostAtStages] = []
        self.constraints: list[ConstraintAtStages] = []
        for term in terms:
            if not isinstance(term, CustomCost | CustomConstraint):
                expected = "expected CustomCost or CustomConstraint"
                raise BadInput("custom terms", "", f"{expected}, got {type(term).__name__}")
            M, stages = term.selection(joints, len(ticks))
            if isinstance(term, CustomCost):
                self.costs.append(CostAtStages(term.term(M), stages))
            else:
                self.constraints.append(term.at(M, stages))

    def added_to(
        self,
        program: MpcProgram,
        predictions: StagePredictions,
        condensing: Condensing,
        scale: np.ndarray,
    ) -> MpcProgram:
        """Returns the program of a tick with the terms.

        Args:
            program: Program without them.
            predictions: Predictions of the tick.
            condensing: Constant part of the programs.
            scale: (m N,) m/s^2 and rad/s^2, inputs per unit of z.
        """

        def values(
            parts: Sequence[tuple[str, np.ndarray]], stages: np.ndarray
        ) -> tuple[np.ndarray, np.ndarray]:
            """Returns L (S d, m N) and b (S, d), where sum_i M_i x_i = L z + b."""
            if parts[0][0] == "input":
                ((_, M),) = parts
                L = M @ np.diag(scale).reshape(-1, len(self._ticks), len(scale)).swapaxes(0, 1)
                b = np.zeros(L.shape[:2])
            else:
                rows, offset = combined(parts, predictions)
                L, b = rows_by_input(condensing, rows), (rows @ program.free_response + offset).T
            return L[stages - 1].reshape(-1, len(scale)), b[stages - 1]

        for term, stages in self.costs:
            L, b = values(term.parts, stages)
            weight = np.multiply.outer(self._ticks[stages - 1], term.weight)
            program = program.with_cost(L, (b - term.desired.T).ravel(), weight.ravel())
        for constraint in self.constraints:
            L, b = values(constraint.parts, constraint.stages)
            lower, upper = (constraint.lower - b).ravel(), (constraint.upper - b).ravel()
            program = program.with_rows(L, lower, upper)
        return program

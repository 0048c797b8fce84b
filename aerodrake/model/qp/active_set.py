"""Dual active-set method for strictly convex quadratic programs."""

import numpy as np
from scipy.linalg.lapack import dposv, dtrtrs

from aerodrake.model.qp.quadratic_program import Constraints, QuadraticProgram
from aerodrake.model.qp.refinement import exact_minimiser
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.qp.solver import QpSolver

TOLERANCE = 1e-9
"""Largest violation of a bound at the solution."""

DEPENDENT = 1e-9
"""Relative squared norm of a constraint normal, after projecting out the active ones, below
which it is linearly dependent on them."""


class ActiveSetSolver(QpSolver):
    """Solves programs exactly by the dual active-set method of Goldfarb and Idnani (1983).

    Starts at the unconstrained minimiser. Adds the most violated constraint, dropping those
    whose multipliers reach zero, until none is violated. z minimises the Lagrangian
    throughout. At the end the optimality conditions are verified.

    Args:
        max_iterations: Largest number of constraints that are added.
    """

    def __init__(self, max_iterations: int):
        self._max_iterations = max_iterations

    def _solve(self, program: QuadraticProgram, constraints: Constraints) -> QpResult:
        active, nz, iterations = ActiveSet(program, constraints), len(program.g), 0
        while not active.is_feasible():
            if iterations == self._max_iterations:
                return QpResult.without_solution(nz, QpStatus.ITERATION_LIMIT, iterations)
            if not active.add_most_violated():
                return QpResult.without_solution(nz, QpStatus.INFEASIBLE, iterations)
            iterations += 1
        sides = np.zeros(len(constraints.N), dtype=int)
        sides[active.indices] = active.sides
        z = exact_minimiser(program, constraints, sides)
        if z is None:
            return QpResult.without_solution(nz, QpStatus.ITERATION_LIMIT, iterations)
        return QpResult(z, QpStatus.SOLVED, iterations)


class ActiveSet:
    """Active constraints n_j z = b_j with outward normals n_j, of the Lagrangian's minimiser z.

    Attributes:
        indices, sides: Index of each active constraint, and 1 for its upper or -1 for its lower
            bound.
        multipliers: (k,), Lagrange multiplier of each.
        z: (nz,), minimiser of the Lagrangian.
    """

    def __init__(self, program: QuadraticProgram, constraints: Constraints):
        self._constraints, self._factor = constraints, program.factor
        self._unconstrained = self.z = program.minimiser
        self.indices: list[int] = []
        self.sides: list[int] = []
        self.multipliers = np.zeros(0)
        self._L_inv_n = np.zeros((0, len(self.z)))  # A row for each active constraint.
        self._violations = constraints.violations(self.z)

    def is_feasible(self) -> bool:
        """Returns True if z violates no constraint."""
        return self._violations.max() <= TOLERANCE

    def add_most_violated(self) -> bool:
        """Adds the most violated constraint; returns False if the program is infeasible."""
        index = int(self._violations.argmax())
        n, violation = self._constraints.N[index], self._violations[index]
        side = 1 if n @ self.z > self._constraints.upper[index] else -1
        L_inv_n = dtrtrs(self._factor, side * n, lower=1)[0]
        norm2, multiplier = L_inv_n @ L_inv_n, 0.0
        while True:
            # Decrease of the active multipliers per increase of the new one.
            overlap = self._L_inv_n @ L_inv_n
            decrease = overlap
            if len(overlap):
                decrease = dposv(self._L_inv_n @ self._L_inv_n.T, overlap)[1]
            projected = norm2 - overlap @ decrease
            is_independent = projected > DEPENDENT * norm2
            step, blocking = violation / projected if is_independent else np.inf, -1
            for j in np.flatnonzero(decrease > 0):
                if self.multipliers[j] < step * decrease[j]:
                    step, blocking = self.multipliers[j] / decrease[j], j
            if not np.isfinite(step):
                return False
            self.multipliers = self.multipliers - step * decrease
            multiplier += step
            violation -= step * projected
            if blocking < 0:
                break
            self._drop(blocking)
        self.indices.append(index)
        self.sides.append(side)
        self.multipliers = np.append(self.multipliers, multiplier)
        self._L_inv_n = np.vstack([self._L_inv_n, L_inv_n])
        pull = self.multipliers @ self._L_inv_n
        self.z = self._unconstrained - dtrtrs(self._factor, pull, lower=1, trans=1)[0]
        self._violations = self._constraints.violations(self.z)
        return True

    def _drop(self, j: int) -> None:
        del self.indices[j], self.sides[j]
        self.multipliers = np.delete(self.multipliers, j)
        self._L_inv_n = np.delete(self._L_inv_n, j, axis=0)

"""Interface of the solvers of quadratic programs."""

from abc import ABC, abstractmethod

from aerodrake.model.qp.quadratic_program import Constraints, QuadraticProgram
from aerodrake.model.qp.result import QpResult


class QpSolver(ABC):
    """Solves programs, each independently of the others.

    A solver keeps no state that affects solutions, so that flights are repeatable from a
    cloned Context. Its limit is a number of iterations, never a time, for the same reason.

    A further solver implements `_solve`, in a file of its own, and gets a name in `make_solver`
    and in `mpc.solver` of a scenario. A solver of Drake needs only an entry in `OTHERS`.
    """

    def solve(self, program: QuadraticProgram) -> QpResult:
        """Solves one program of any size."""
        if (status := program.defect()) is not None:
            return QpResult.without_solution(len(program.g), status)
        return self._solve(program, Constraints.of(program))

    @abstractmethod
    def _solve(self, program: QuadraticProgram, constraints: Constraints) -> QpResult:
        """Solves a program of finite numbers with nonempty bounds and H positive definite."""

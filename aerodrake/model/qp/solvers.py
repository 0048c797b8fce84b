"""Solvers of quadratic programs by name."""

from collections.abc import Callable, Mapping

from pydrake.solvers import (
    ClarabelSolver,
    GurobiSolver,
    MosekSolver,
    ScsSolver,
    SolverInterface,
)

from aerodrake.model.qp.active_set import ActiveSetSolver
from aerodrake.model.qp.drake_solver import DrakeQpSolver
from aerodrake.model.qp.osqp import make_osqp
from aerodrake.model.qp.solver import QpSolver
from aerodrake.support.errors import BadInput

OTHERS: Mapping[str, Callable[[], SolverInterface]] = {
    "clarabel": ClarabelSolver,
    "gurobi": GurobiSolver,
    "mosek": MosekSolver,
    "scs": ScsSolver,
}
"""Drake's other solvers for convex quadratic programs, with their default options.

Without CLP, whose quadratic programs Drake does not officially support, and without nonlinear
solvers.
"""

SOLVERS = ("osqp", "active_set", *OTHERS)
"""Names of all solvers, as in `mpc.solver` of a scenario."""


def available_solvers() -> tuple[str, ...]:
    """Returns the names of the solvers that are built in, and licensed if they need it."""
    others = (name for name, make in OTHERS.items() if make().available() and make().enabled())
    return ("osqp", "active_set", *others)


def make_solver(name: str, max_iterations: int, is_refined: bool = True) -> QpSolver:
    """Returns a solver.

    Args:
        name: One of `SOLVERS`.
        max_iterations: Iteration limit of `osqp` and `active_set`; the others have their own.
        is_refined: As for `DrakeQpSolver`.

    Raises:
        BadInput: if this machine lacks the solver or its license.
    """
    if name not in available_solvers():
        names = ", ".join(available_solvers())
        raise BadInput("", "", f"no {name} on this machine; available: {names}")
    if name == "osqp":
        return make_osqp(max_iterations, is_refined)
    if name == "active_set":
        return ActiveSetSolver(max_iterations)
    return DrakeQpSolver(OTHERS[name](), {}, is_refined)

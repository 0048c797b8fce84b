"""OSQP through Drake: operator splitting, the solver of record."""

from pydrake.solvers import OsqpSolver

from aerodrake.model.qp.drake_solver import DrakeQpSolver

OPTIONS = {
    "scaling": 0,  # `ScaledProgram.update` scales.
    "rho": 0.3,
    "adaptive_rho_interval": 25,  # The default depends on wall time.
    "check_termination": 25,
    "eps_abs": 1e-6,
    "eps_rel": 1e-6,
    "polishing": 0,  # `exact_minimiser` does it with the Cholesky factor of H.
}


def make_osqp(max_iterations: int, is_refined: bool = True) -> DrakeQpSolver:
    """Returns OSQP for well-scaled programs (Stellato et al. 2020, doi 10.1007/s12532-020-00179-2).

    Args:
        max_iterations: Largest number of iterations.
        is_refined: As for `DrakeQpSolver`.
    """
    return DrakeQpSolver(OsqpSolver(), OPTIONS | {"max_iter": max_iterations}, is_refined)

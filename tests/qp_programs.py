"""Random quadratic programs for the tests of the solvers."""

from dataclasses import replace

import numpy as np

from aerodrake.bench.exact import exact_minimiser
from aerodrake.model.qp.quadratic_program import QuadraticProgram

NZ, ROWS = 12, 20


def random_program(seed: int, pull: float = 2.0, slack: float = 0.3) -> QuadraticProgram:
    """Returns a feasible program; `pull` is the size of the unconstrained minimiser."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(ROWS, NZ))
    A /= np.linalg.norm(A, axis=1)[:, None]
    F = rng.normal(size=(NZ, NZ))
    H = F.T @ F + 0.1 * np.eye(NZ)
    g = -H @ rng.uniform(-pull, pull, NZ)
    inside = A @ rng.uniform(-0.5, 0.5, NZ)
    lower = inside - slack * rng.uniform(0.01, 1, ROWS)
    upper = inside + slack * rng.uniform(0.01, 1, ROWS)
    return QuadraticProgram(H, g, A, lower, upper)


def degenerate(program: QuadraticProgram) -> QuadraticProgram:
    """Returns the program with each row twice, and with sums of rows, of the same solution."""
    A, lower, upper = program.A, program.lower, program.upper
    sums = A[:-1] + A[1:]
    norms = np.linalg.norm(sums, axis=1)
    return replace(
        program,
        A=np.vstack([A, A, sums / norms[:, None]]),
        lower=np.concatenate([lower, lower, (lower[:-1] + lower[1:]) / norms]),
        upper=np.concatenate([upper, upper, (upper[:-1] + upper[1:]) / norms]),
    )


def infeasible(program: QuadraticProgram) -> QuadraticProgram:
    """Returns the program with a row and its opposite bound: a solver has to find out."""
    A, lower, upper = program.A.copy(), program.lower.copy(), program.upper.copy()
    A[1] = A[0]
    lower[:2], upper[:2] = [0.3, -0.4], [0.4, -0.3]
    return replace(program, A=A, lower=lower, upper=upper)


def best(program: QuadraticProgram) -> np.ndarray:
    """Returns the minimiser (nz,) by an independent method, see `exact_minimiser`."""
    optimum = exact_minimiser(program.H, program.g, program.lower, program.upper, program.A)
    assert optimum.residual < 1e-9
    return optimum.z

"""Solvers from PyPI for comparison with the MPC's solver.

All get the same programs in the same scaling: |z| <= 1, the rows of A of unit norm. Their
times include removing redundant constraints, scaling the cost, updating and solving. The
settings are the fastest of those tried that bring u_0 to within 1e-3 m/s^2 and rad/s^2 of
the optimum on recorded ticks.
"""

from abc import ABC, abstractmethod
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
from numpy import ndarray
from scipy import sparse


class Peer(ABC):
    """A solver of programs with a common A (rows, nz).

    Attributes:
        package: Name at PyPI.
        settings: Description of all settings that are not defaults.
    """

    package: ClassVar[str]
    settings: ClassVar[str]

    def __init__(self, A: ndarray):
        self.A = A
        self._one = np.ones(A.shape[1])
        self._reach = np.abs(A).sum(axis=1)
        self._library: Any = import_module(self.package)
        self._set_up()

    @abstractmethod
    def _set_up(self) -> None:
        """Sets up the solver before the first program."""

    @abstractmethod
    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        """Returns the minimiser (nz,), or the last iterate.

        Args:
            H: (nz, nz), symmetric and positive definite.
            g: (nz,).
            lower, upper: (rows,), infinite where there is no bound.
        """

    def _without_redundant(self, lower: ndarray, upper: ndarray) -> tuple[ndarray, ...]:
        """Returns the bounds, infinite for redundant constraints, and which rows remain (rows,)."""
        above, below = upper < self._reach, lower > -self._reach
        return np.where(below, lower, -np.inf), np.where(above, upper, np.inf), above | below


class Daqp(Peer):
    """Dual active-set method; it returns the unconstrained minimiser at once if feasible."""

    package = "daqp"
    settings = "daqp.solve without redundant rows, dual_start with the last multipliers if any"

    def _set_up(self) -> None:
        self._dual = np.zeros(sum(self.A.shape))

    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        # The bounds stay finite: dual_start with an infinite one gives NaN.
        _, _, needed = self._without_redundant(lower, upper)
        remaining = np.concatenate([np.ones(len(g), dtype=bool), needed])
        high = np.concatenate([self._one, upper[needed]])
        low = np.concatenate([-self._one, lower[needed]])
        # dual_start without active constraints only costs time.
        start = self._dual[remaining] if self._dual.any() else None
        z, _, _, info = self._library.solve(H, g, self.A[needed], high, low, dual_start=start)
        self._dual[:] = 0
        self._dual[remaining] = info["lam"]
        return z


class Piqp(Peer):
    """Proximal interior point, dense."""

    package = "piqp"
    settings = (
        "DenseSolver, without redundant rows, update while these are the same, cost by its mean "
        "diagonal, preconditioner_iter 0, all eps 1e-9"
    )

    def _set_up(self) -> None:
        self._rows = np.zeros(0, dtype=bool)
        self._solver = self._library.DenseSolver()
        settings = self._solver.settings
        settings.preconditioner_iter = 0
        for name in ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel"):
            setattr(settings, name, 1e-9)

    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        lower, upper, needed = self._without_redundant(lower, upper)
        scale, low, high = 1 / np.diag(H).mean(), lower[needed], upper[needed]
        if np.array_equal(needed, self._rows):
            self._solver.update(P=H * scale, c=g * scale, h_l=low, h_u=high)
        else:
            self._rows, A, one = needed, self.A[needed], self._one
            self._solver.setup(H * scale, g * scale, None, None, A, low, high, -one, one)
        self._solver.solve()
        return np.array(self._solver.result.x)


class ProxQp(Peer):
    """Proximal augmented Lagrangian, dense."""

    package = "proxsuite"
    settings = (
        "dense.QP with box constraints, all rows, update, warm start with the previous result, "
        "cost by its mean diagonal, no preconditioner, eps_abs 1e-9, rho 1e-7, mu_in 1e-2"
    )

    def _set_up(self) -> None:
        library = self._library.proxqp
        rows, nz = self.A.shape
        self._solver = library.dense.QP(nz, 0, rows, True)
        self._solver.settings.eps_abs = 1e-9
        self._solver.settings.initial_guess = library.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
        self._is_new = True

    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        lower, upper, _ = self._without_redundant(lower, upper)
        scale = 1 / np.diag(H).mean()
        box = {"l_box": -self._one, "u_box": self._one}
        program: dict[str, Any] = {"H": H * scale, "g": g * scale, "l": lower, "u": upper, **box}
        if self._is_new:
            self._is_new = False
            self._solver.init(
                **program, C=self.A, compute_preconditioner=False, rho=1e-7, mu_in=1e-2
            )
        else:
            self._solver.update(**program, update_preconditioner=False)
        self._solver.solve()
        return np.array(self._solver.results.x)


class Sparse(Peer):
    """Base class of the two sparse solvers."""

    def _set_up(self) -> None:
        nz = self.A.shape[1]
        self._triangle = sparse.csc_matrix(np.triu(np.ones((nz, nz))))
        columns = np.repeat(np.arange(nz), np.diff(self._triangle.indptr))
        self._entries = self._triangle.indices * nz + columns
        self._solver: Any = None

    def _cost(self, H: ndarray, g: ndarray) -> tuple[ndarray, ndarray]:
        """Returns the upper triangle of H by columns, and g, both over the mean diagonal of H."""
        scale = 1 / np.diag(H).mean()
        return scale * H.ravel()[self._entries], scale * g

    def _upper(self, entries: ndarray) -> sparse.csc_matrix:
        triangle = self._triangle.copy()
        triangle.data = entries
        return triangle


class Osqp(Sparse):
    """Operator splitting: the MPC's solver, called without Drake and without refinement."""

    package = "osqp"
    settings = (
        "all rows, update, warm start with the previous result, cost by its mean diagonal, "
        "scaling 0, rho 0.03, adaptive_rho_interval 25, check_termination 10, eps 5e-8, "
        "max_iter 4000"
    )

    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        lower, upper, _ = self._without_redundant(lower, upper)
        entries, g = self._cost(H, g)
        low, high = np.concatenate([-self._one, lower]), np.concatenate([self._one, upper])
        if self._solver is None:
            self._solver = self._library.OSQP()
            A = sparse.csc_matrix(np.vstack([np.eye(len(g)), self.A]))
            step = {"scaling": 0, "rho": 0.03, "adaptive_rho_interval": 25, "verbose": False}
            end = {"check_termination": 10, "eps_abs": 5e-8, "eps_rel": 5e-8, "max_iter": 4000}
            self._solver.setup(self._upper(entries), g, A, low, high, **step, **end)
        else:
            self._solver.update(Px=entries, q=g, l=low, u=high)
        return np.array(self._solver.solve(raise_error=False).x)


class Clarabel(Sparse):
    """Interior point, without warm start; its workspace is reused."""

    package = "clarabel"
    settings = (
        "without redundant rows, update while these are the same, cost by its mean diagonal, "
        "no equilibration, no iterative refinement, no presolve, tol_gap 1e-9"
    )

    def _set_up(self) -> None:
        super()._set_up()
        self._bounds = np.zeros(0, dtype=bool)

    def solve(self, H: ndarray, g: ndarray, lower: ndarray, upper: ndarray) -> ndarray:
        lower, upper, _ = self._without_redundant(lower, upper)
        entries, g = self._cost(H, g)
        bounds = np.concatenate([upper, -lower])
        finite = np.isfinite(bounds)
        b = np.concatenate([self._one, self._one, bounds[finite]])
        if np.array_equal(finite, self._bounds):
            self._solver.update(P=entries, q=g, b=b)
        else:
            self._bounds, eye = finite, np.eye(len(g))
            rows = np.vstack([eye, -eye, np.vstack([self.A, -self.A])[finite]])
            settings = self._library.DefaultSettings()
            settings.verbose = settings.equilibrate_enable = settings.presolve_enable = False
            settings.iterative_refinement_enable = settings.input_sparse_dropzeros = False
            settings.tol_gap_abs = settings.tol_gap_rel = 1e-9
            cones = [self._library.NonnegativeConeT(len(b))]
            self._solver = self._library.DefaultSolver(
                self._upper(entries), g, sparse.csc_matrix(rows), b, cones, settings
            )
        return np.array(self._solver.solve().x)


PEERS = {"daqp": Daqp, "piqp": Piqp, "proxqp": ProxQp, "osqp": Osqp, "clarabel": Clarabel}

"""Solvers from PyPI that the MPC's is measured against, each as it is fastest.

Every one gets the same program in the same scaling: |z| <= 1, the rows of A of unit norm.
What it does with it counts as its time: screening out the rows that no z in the box can
violate, scaling the cost, updating and solving. The settings are the fastest
of those tried that bring u_0 to within 1e-3 m/s^2 and rad/s^2 of the optimum on recorded
ticks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
from scipy import sparse


class Peer(ABC):
    """A solver of the programs that share A (rows, nz).

    Attributes:
        package: What it is called at PyPI.
        settings: All that is not its default, in words.
    """

    package: ClassVar[str]
    settings: ClassVar[str]

    def __init__(self, A: np.ndarray):
        self.A = A
        self._one = np.ones(A.shape[1])
        self._reach = np.abs(A).sum(axis=1)
        self._library: Any = import_module(self.package)
        self._set_up()

    @abstractmethod
    def _set_up(self) -> None:
        """Does what can be done before the first program."""

    @abstractmethod
    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        """(nz,), the minimiser, or its best guess.

        Args:
            H: (nz, nz), symmetric and positive definite.
            g: (nz,).
            lower, upper: (rows,), infinite where there is no bound.
        """

    def _screened(
        self, lower: np.ndarray, upper: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The bounds, infinite where out of reach, and (rows,) which rows have one that is not."""
        above, below = upper < self._reach, lower > -self._reach
        return np.where(below, lower, -np.inf), np.where(above, upper, np.inf), above | below


class Daqp(Peer):
    """Dual active set; its own shortcut tells the unconstrained minimiser."""

    package = "daqp"
    settings = "daqp.solve of the live rows, dual_start with the last multipliers if any"

    def _set_up(self) -> None:
        self._dual = np.zeros(sum(self.A.shape))

    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        # With finite bounds: a start at an infinite one gives nan.
        _, _, live = self._screened(lower, upper)
        kept = np.concatenate([np.ones(len(g), dtype=bool), live])
        # A start without active bounds is no start, and costs time.
        start = self._dual[kept] if self._dual.any() else None
        z, _, _, info = self._library.solve(
            H,
            g,
            self.A[live],
            np.concatenate([self._one, upper[live]]),
            np.concatenate([-self._one, lower[live]]),
            dual_start=start,
        )
        self._dual[:] = 0
        self._dual[kept] = info["lam"]
        return z


class Piqp(Peer):
    """Proximal interior point, dense."""

    package = "piqp"
    settings = (
        "DenseSolver, the live rows, update while they are the same ones, cost by its mean "
        "diagonal, preconditioner_iter 0, all eps 1e-9"
    )

    def _set_up(self) -> None:
        self._rows = np.zeros(0, dtype=bool)
        self._solver = self._library.DenseSolver()
        settings = self._solver.settings
        settings.preconditioner_iter = 0
        for name in ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel"):
            setattr(settings, name, 1e-9)

    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        lower, upper, live = self._screened(lower, upper)
        scale, low, high = 1 / np.diag(H).mean(), lower[live], upper[live]
        if np.array_equal(live, self._rows):
            self._solver.update(P=H * scale, c=g * scale, h_l=low, h_u=high)
        else:
            self._rows, A = live, self.A[live]
            one = self._one
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

    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        lower, upper, _ = self._screened(lower, upper)
        scale = 1 / np.diag(H).mean()
        program: dict[str, Any] = {
            "H": H * scale,
            "g": g * scale,
            "l": lower,
            "u": upper,
            "l_box": -self._one,
            "u_box": self._one,
        }
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
    """What the two sparse solvers have in common."""

    def _set_up(self) -> None:
        nz = self.A.shape[1]
        self._triangle = sparse.csc_matrix(np.triu(np.ones((nz, nz))))
        columns = np.repeat(np.arange(nz), np.diff(self._triangle.indptr))
        self._entries = self._triangle.indices * nz + columns
        self._solver: Any = None

    def _cost(self, H: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The upper triangle of H by columns, and g, both by H's mean diagonal."""
        scale = 1 / np.diag(H).mean()
        return scale * H.ravel()[self._entries], scale * g

    def _upper(self, entries: np.ndarray) -> sparse.csc_matrix:
        triangle = self._triangle.copy()
        triangle.data = entries
        return triangle


class Osqp(Sparse):
    """Operator splitting: the library that the MPC falls back on, without Drake around it."""

    package = "osqp"
    settings = (
        "all rows, update, warm start with the previous result, cost by its mean diagonal, "
        "scaling 0, rho 0.03, adaptive_rho_interval 25, check_termination 10, eps 5e-8, "
        "max_iter 4000"
    )

    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        lower, upper, _ = self._screened(lower, upper)
        entries, g = self._cost(H, g)
        low, high = np.concatenate([-self._one, lower]), np.concatenate([self._one, upper])
        if self._solver is None:
            self._solver = self._library.OSQP()
            A = sparse.csc_matrix(np.vstack([np.eye(len(g)), self.A]))
            self._solver.setup(
                self._upper(entries),
                g,
                A,
                low,
                high,
                verbose=False,
                scaling=0,
                rho=0.03,
                adaptive_rho_interval=25,
                check_termination=10,
                eps_abs=5e-8,
                eps_rel=5e-8,
                max_iter=4000,
            )
        else:
            self._solver.update(Px=entries, q=g, l=low, u=high)
        return np.array(self._solver.solve(raise_error=False).x)


class Clarabel(Sparse):
    """Interior point; it has no warm start, only its workspace stays."""

    package = "clarabel"
    settings = (
        "the live rows, update while they are the same ones, cost by its mean diagonal, "
        "no equilibration, no iterative refinement, no presolve, tol_gap 1e-9"
    )

    def _set_up(self) -> None:
        super()._set_up()
        self._bounds = np.zeros(0, dtype=bool)

    def solve(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> np.ndarray:
        lower, upper, _ = self._screened(lower, upper)
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


PEERS: dict[str, type[Peer]] = {
    "daqp": Daqp,
    "piqp": Piqp,
    "proxqp": ProxQp,
    "osqp": Osqp,
    "clarabel": Clarabel,
}

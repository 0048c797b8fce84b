"""Elimination of states and task vectors from the program of one tick."""

from typing import NamedTuple

import numpy as np
from pydrake.solvers import Binding
from scipy import sparse
from scipy.sparse.linalg import splu

from aerodrake.model.mpc.tick_program import TickProgram


class Eliminated(NamedTuple):
    """min U' H U / 2 + g' U subject to lower <= A U <= upper, with U (N m,), tick by tick.

    |U| <= box.
    """

    H: np.ndarray
    g: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    box: np.ndarray


def eliminate(program: TickProgram) -> Eliminated:
    """Solves the equality constraints for all variables but the inputs.

    Reads only what Drake's MathematicalProgram reports.
    """
    count, U = program.num_vars(), program.u.ravel()
    inputs = program.FindDecisionVariableIndices(U)
    others = np.setdiff1d(np.arange(count), inputs)
    E = _rows(program, program.linear_equality_constraints())
    e = np.concatenate([b.evaluator().lower_bound() for b in program.linear_equality_constraints()])
    by_input = splu(E[:, others]).solve(np.column_stack([-E[:, inputs].toarray(), e]))
    T, t = np.zeros((count, len(U))), np.zeros(count)  # All variables are T U + t.
    T[inputs] = np.eye(len(U))
    T[others], t[others] = by_input[:, :-1], by_input[:, -1]
    H, g = np.zeros((len(U), len(U))), np.zeros(len(U))
    for binding in program.quadratic_costs():
        index = program.FindDecisionVariableIndices(binding.variables())
        Q, b = binding.evaluator().Q(), binding.evaluator().b()
        H += T[index].T @ Q @ T[index]
        g += T[index].T @ (Q @ t[index] + b)
    bounds = [*program.bounding_box_constraints(), *program.linear_constraints()]
    rows = _rows(program, bounds)
    lower = np.concatenate([b.evaluator().lower_bound() for b in bounds]) - rows @ t
    upper = np.concatenate([b.evaluator().upper_bound() for b in bounds]) - rows @ t
    is_input = np.arange(len(U))  # Their boxes come first.
    is_state = np.arange(len(U), rows.shape[0])
    assert (rows[is_input][:, inputs].toarray() == np.eye(len(U))).all()
    np.testing.assert_array_equal(lower[is_input], -upper[is_input])
    A = rows @ T
    return Eliminated(H, g, A[is_state], lower[is_state], upper[is_state], upper[is_input])


def _rows(program: TickProgram, bindings: list[Binding]) -> sparse.csc_matrix:
    """Returns the matrix of linear constraints over all variables of a program."""
    parts, row = [], 0
    for binding in bindings:
        A = binding.evaluator().GetDenseA()
        index = np.array(program.FindDecisionVariableIndices(binding.variables()))
        at = A.nonzero()
        parts.append((A[at], at[0] + row, index[at[1]]))
        row += len(A)
    data, rows, columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    return sparse.csc_matrix((data, (rows, columns)), shape=(row, program.num_vars()))


def assert_same_program(program: TickProgram, condensed, formulation) -> None:
    """Asserts that the eliminated form of a program is the condensed one, to 1e-9."""
    eliminated = eliminate(program)
    N, m = program.u.shape
    by_axis = np.arange(N * m).reshape(N, m).T.ravel()  # From z to U, tick by tick.
    scale = formulation.scale
    H = eliminated.H[np.ix_(by_axis, by_axis)] * np.multiply.outer(scale, scale) / 2
    g, A = eliminated.g[by_axis] * scale / 2, eliminated.A[:, by_axis] * scale
    norms = np.linalg.norm(A, axis=1)
    A, lower, upper = A / norms[:, None], eliminated.lower / norms, eliminated.upper / norms
    np.testing.assert_allclose(eliminated.box[by_axis], scale, rtol=1e-12)
    largest = np.abs(H).max()
    np.testing.assert_allclose(condensed.H, H, rtol=0, atol=1e-9 * largest)
    np.testing.assert_allclose(condensed.g, g, rtol=0, atol=1e-9 * max(np.abs(g).max(), largest))
    np.testing.assert_allclose(condensed.A, A, rtol=0, atol=1e-9)
    for ours, theirs in ((condensed.lower, lower), (condensed.upper, upper)):
        np.testing.assert_array_equal(np.isfinite(ours), np.isfinite(theirs))
        finite = np.isfinite(ours)
        np.testing.assert_allclose(ours[finite], theirs[finite], rtol=1e-9, atol=1e-9)

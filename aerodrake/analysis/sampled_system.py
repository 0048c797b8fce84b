"""Linear system in discrete time with named states, inputs and outputs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from aerodrake.support.errors import BadInput, nearest

if TYPE_CHECKING:
    from scipy.signal import StateSpace


@dataclass(frozen=True)
class SampledSystem:
    """Linear system x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k] about a trajectory.

    All values are deviations from the trajectory, in SI units. The inputs are constant over a
    period. An attitude is a rotation vector in the base frame.

    Attributes:
        A: (nx, nx).
        B: (nx, nu).
        C: (ny, nx).
        D: (ny, nu).
        dt: s, the period.
        states: nx names, such as `plant.roll`, `plant.joint_2_rate` or
            `flight_controller.position_observer[4]`.
        inputs: nu names, such as `force_x`.
        outputs: ny names, such as `tool_x`.
        state_scale: (nx,) typical size of each state, in its unit. Norms of states are taken after
            division by it.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    dt: float
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    state_scale: np.ndarray

    @property
    def state_space(self) -> "StateSpace":
        """The same system in SciPy's form, for `scipy.signal` and `control.ss`."""
        from scipy.signal import StateSpace  # Importing it takes half a second.

        return StateSpace(self.A, self.B, self.C, self.D, dt=self.dt)

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """(nx,) eigenvalues of A, the largest first."""
        values = np.linalg.eigvals(self.A / self.state_scale[:, None] * self.state_scale)
        return values[np.argsort(-np.abs(values), kind="stable")]

    def between(self, inputs: Sequence[str], outputs: Sequence[str]) -> Self:
        """Returns the system with some of its inputs and outputs, in the order of their names.

        Raises:
            BadInput: if there is no input or output of a name.
        """
        columns = [_index(self.inputs, "inputs", name) for name in inputs]
        rows = [_index(self.outputs, "outputs", name) for name in outputs]
        return replace(
            self,
            B=self.B[:, columns],
            C=self.C[rows],
            D=self.D[np.ix_(rows, columns)],
            inputs=tuple(inputs),
            outputs=tuple(outputs),
        )


def _index(names: Sequence[str], argument: str, name: str) -> int:
    if name not in names:
        raise BadInput("SampledSystem", argument, f"no '{name}'; {nearest(name, names)}")
    return names.index(name)

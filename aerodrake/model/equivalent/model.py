"""Equivalent kinematic models of the base under its flight controller, and of the arm.

The model is linear and time-invariant, x+ = A x + B u + C Delta (paper, eq. 5), with

    x = [p_Bx, p_Bx', p_Bx,d, p_Bx,d', ..., p_By, ..., q_1, q_1', ..., q_n, q_n'],
    u = [p_Bx,d'', p_By,d'', p_Bz,d'', q_1'', ..., q_n''],

and Delta (3,) the residual of the base: its residual velocity in m/s in the models that have
K_B alone, its residual acceleration in m/s^2 in the flight model. The joints are double integrators
of the command. The kinds of model differ in the response of the base's axes to their setpoint,
and in the states of that response.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.linalg import block_diag

from aerodrake.model.equivalent.axis_models import (
    AXIS_MODELS,
    HIDDEN_STATES,
    AxisModel,
    ResidualQuantity,
    flight_axis,
)
from aerodrake.model.equivalent.initial_state import Signals, StateLayout, Thrust, initial_state
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import Count, Period, Vector3, checked
from aerodrake.support.errors import BadInput, nearest


@dataclass(frozen=True)
class EquivalentModel:
    """x+ = A x + B u + C Delta, and the indices of the quantities in x.

    Attributes:
        A: (nx, nx), nx = 3 m + 2 n for m states per axis of the base.
        B: (nx, 3 + n).
        C: (nx, 3), the paper's C restricted to its non-zero columns.
        dt: s, period.
        axis_states: Names of the m states of an axis.
        acceleration: (3, nx), maps x to the acceleration that tilts the base.
        base_is_commanded: True if x_0 takes the base from its setpoint.
        residual: Quantity that Delta is, with its unit.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    dt: float
    axis_states: tuple[str, ...]
    acceleration: np.ndarray
    base_is_commanded: bool
    residual: ResidualQuantity

    @classmethod
    @checked
    def of(cls, scenario: Scenario, joints: Count) -> Self:
        """Returns the scenario's model at the rate of its MPC, for n `joints`."""
        config, rates = scenario.model, scenario.rates
        if config.kind != "flight":
            return cls.make(config.kind, np.array(config.k_b), rates.mpc_period_s, joints)
        rotor, period = scenario.vehicle.rotor, rates.flight_period_s
        axes = [
            flight_axis(axis, scenario.flight, rotor, period, rates.mpc_period_s)
            for axis in range(3)
        ]
        return cls._assemble(axes, rates.mpc_period_s, joints, base_is_commanded=False)

    @classmethod
    @checked
    def make(cls, kind: str, k_b: Vector3, dt: Period, joints: Count) -> Self:
        """Returns one of the models that have K_B as their only parameter.

        Args:
            kind: A key of `AXIS_MODELS`.
            k_b: (3,) 1/s.
            dt: s.
            joints: n.

        Raises:
            BadInput: if there is no such model.
        """
        if kind not in AXIS_MODELS:
            message = f"unknown value '{kind}'; {nearest(kind, AXIS_MODELS)}"
            raise BadInput("EquivalentModel.make", "kind", message)
        axes = [AXIS_MODELS[kind](k, dt) for k in k_b]
        return cls._assemble(axes, dt, joints, base_is_commanded=kind == "integral")

    @classmethod
    def _assemble(
        cls, axes: list[AxisModel], dt: float, joints: int, base_is_commanded: bool
    ) -> Self:
        joint = np.array([[1, dt], [0, 1]]), np.array([[dt**2 / 2], [dt]])
        A = block_diag(*(axis.A for axis in axes), *[joint[0]] * joints)
        B = block_diag(*(axis.B[:, None] for axis in axes), *[joint[1]] * joints)
        C, acceleration = np.zeros((len(A), 3)), np.zeros((3, len(A)))
        base = 3 * len(axes[0].states)
        C[:base] = block_diag(*(axis.C[:, None] for axis in axes))
        acceleration[:, :base] = block_diag(*(axis.acceleration for axis in axes))
        states, residual = axes[0].states, axes[0].residual
        return cls(A, B, C, dt, states, acceleration, base_is_commanded, residual)

    @cached_property
    def joints(self) -> int:
        """Number n of joints."""
        return self.B.shape[1] - 3

    @cached_property
    def _layout(self) -> StateLayout:
        names = [name for name in Thrust._fields if name in self.axis_states]
        setpoint = self.setpoint_position, self.setpoint_velocity
        return StateLayout(
            np.array([self.base_position, self.base_velocity, *setpoint]),
            np.array([self.base_state(name) for name in names], dtype=int).reshape(-1, 3),
            np.array([self.joint_position, self.joint_velocity]),
            self.hidden,
            self.A[self.hidden],
            self.B[self.hidden],
            self.base_is_commanded,
        )

    def base_state(self, name: str) -> np.ndarray:
        """Returns the indices (3,) in x of a state of the base's axes, by its name."""
        m = len(self.axis_states)
        return m * np.arange(3) + self.axis_states.index(name)

    base_position = cached_property(lambda self: self.base_state("p"))
    """(3,) indices of p_B in x."""
    base_velocity = cached_property(lambda self: self.base_state("v"))
    """(3,) indices of p_B' in x."""
    setpoint_position = cached_property(lambda self: self.base_state("p_d"))
    """(3,) indices of p_B,d in x."""
    setpoint_velocity = cached_property(lambda self: self.base_state("v_d"))
    """(3,) indices of p_B,d' in x."""

    @cached_property
    def joint_position(self) -> np.ndarray:
        """(n,) indices of q in x."""
        return 3 * len(self.axis_states) + 2 * np.arange(self.joints)

    @cached_property
    def joint_velocity(self) -> np.ndarray:
        """(n,) indices of q' in x."""
        return self.joint_position + 1

    @cached_property
    def hidden(self) -> np.ndarray:
        """(k,) indices in x of states that are not measured; k = 0 in models with K_B alone."""
        names = [name for name in HIDDEN_STATES if name in self.axis_states]
        return np.array([i for name in names for i in self.base_state(name)], dtype=int)

    @cached_property
    def residual_gain(self) -> np.ndarray:
        """(3,) c, the velocity in m/s that a Delta of one unit adds in a period.

        It is the diagonal of C in the rows of p_B': 1 in the paper's model, about dt in the
        flight model, 0 in the integral model, in which Delta has no effect.
        """
        return self.C[self.base_velocity].diagonal()

    def initial_state(self, signals: Signals, last: np.ndarray | None = None) -> np.ndarray:
        """Returns x_0 (nx,) from measurement and command.

        The arm's state is its setpoint (paper, section II-B), and so is the base's in the
        integral model. Hidden states are predicted from `last` (nx,), x_0 of the last tick, and
        the acceleration that was commanded since, with a Delta of zero; without it they are zero.
        """
        has_last = last is not None and len(self.hidden) > 0
        last = last if has_last else np.zeros(len(self.A))
        return initial_state(self._layout, signals, last, has_last)

    def next_velocity(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Returns the base's velocity (3,) m/s one period later, with a Delta of zero.

        Args:
            x: (nx,) the state.
            u: (3 + n,) m/s^2 and rad/s^2.
        """
        return self.A[self.base_velocity] @ x + self.B[self.base_velocity] @ u

    def predict(self, x: np.ndarray, u: np.ndarray, delta: np.ndarray) -> np.ndarray:
        """Returns the state (nx,) one period later.

        Args:
            x: (nx,) the state.
            u: (3 + n,) m/s^2 and rad/s^2.
            delta: (3,) Delta, in the unit of `residual`.
        """
        return self.A @ x + self.B @ u + self.C @ delta

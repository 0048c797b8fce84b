"""Equivalent kinematic models of the base under its flight controller, and of the arm.

One linear, time-invariant model x+ = A x + B u + C Delta (paper, eq. 5), with

    x = [p_Bx, p_Bx', p_Bx,d, p_Bx,d', ..., p_By, ..., q_1, q_1', ..., q_n, q_n'],
    u = [p_Bx,d'', p_By,d'', p_Bz,d'', q_1'', ..., q_n''],

and Delta the residual velocity of the base. The joints are double integrators
of the command; the kinds differ in how an axis of the base answers its setpoint,
and in the states this takes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from aerodrake.model.equivalent.axis_models import AXIS_MODELS, AxisModel
from aerodrake.model.equivalent.flight_axis import HIDDEN_STATES, flight_axis
from aerodrake.model.equivalent.initial_state import NO_THRUST, Places, Thrust, initial_state
from aerodrake.scenario import Scenario


@dataclass(frozen=True)
class EquivalentModel:
    """x+ = A x + B u + C Delta, and where each quantity stands in x.

    Attributes:
        A: (nx, nx), nx = 3 m + 2 n for m states per axis of the base.
        B: (nx, 3 + n).
        C: (nx, 3), the paper's C restricted to its non-zero columns.
        dt: s, period.
        axis_states: Names of the m states of an axis.
        acceleration: (3, nx), the acceleration that tilts the base, by x.
        believes_command: whether x_0 takes the base from the setpoint.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    dt: float
    axis_states: tuple[str, ...]
    acceleration: np.ndarray
    believes_command: bool

    @classmethod
    def of(cls, scenario: Scenario, joints: int) -> EquivalentModel:
        """The model that the scenario names, at its MPC's rate, for n `joints`."""
        config, rates = scenario.model, scenario.rates
        if config.kind != "flight":
            return cls.make(config.kind, np.array(config.k_b), rates.mpc_period_s, joints)
        rotor, period = scenario.vehicle.rotor, rates.flight_period_s
        axes = [
            flight_axis(axis, scenario.flight, rotor, period, rates.mpc_period_s)
            for axis in range(3)
        ]
        return cls._assemble(axes, rates.mpc_period_s, joints, believes_command=False)

    @classmethod
    def make(cls, kind: str, k_b: np.ndarray, dt: float, joints: int) -> EquivalentModel:
        """One of the models with K_B alone.

        Args:
            kind: A key of `AXIS_MODELS`.
            k_b: (3,) 1/s.
            dt: s.
            joints: n.
        """
        axes = [AXIS_MODELS[kind](k, dt) for k in k_b]
        return cls._assemble(axes, dt, joints, believes_command=kind == "integral")

    @classmethod
    def _assemble(
        cls, axes: list[AxisModel], dt: float, joints: int, believes_command: bool
    ) -> EquivalentModel:
        joint = np.array([[1, dt], [0, 1]]), np.array([[dt**2 / 2], [dt]])
        A = block_diag(*(axis.A for axis in axes), *[joint[0]] * joints)
        B = block_diag(*(axis.B[:, None] for axis in axes), *[joint[1]] * joints)
        C, acceleration = np.zeros((len(A), 3)), np.zeros((3, len(A)))
        base = 3 * len(axes[0].states)
        C[:base] = block_diag(*(axis.C[:, None] for axis in axes))
        acceleration[:, :base] = block_diag(*(axis.acceleration for axis in axes))
        return cls(A, B, C, dt, axes[0].states, acceleration, believes_command)

    @cached_property
    def joints(self) -> int:
        """n."""
        return self.B.shape[1] - 3

    @cached_property
    def _places(self) -> Places:
        names = [name for name in Thrust._fields if name in self.axis_states]
        setpoint = self.setpoint_position, self.setpoint_velocity
        return Places(
            np.array([self.base_position, self.base_velocity, *setpoint]),
            np.array([self.base_state(name) for name in names], dtype=int).reshape(-1, 3),
            np.array([self.joint_position, self.joint_velocity]),
            self.hidden,
            self.A[self.hidden],
            self.B[self.hidden],
            self.believes_command,
        )

    def base_state(self, name: str) -> np.ndarray:
        """(3,) indices in x of a state that each axis of the base has."""
        m = len(self.axis_states)
        return m * np.arange(3) + self.axis_states.index(name)

    @cached_property
    def base_position(self) -> np.ndarray:
        """(3,) indices of p_B in x."""
        return self.base_state("p")

    @cached_property
    def base_velocity(self) -> np.ndarray:
        """(3,) indices of p_B' in x."""
        return self.base_state("v")

    @cached_property
    def setpoint_position(self) -> np.ndarray:
        """(3,) indices of p_B,d in x."""
        return self.base_state("p_d")

    @cached_property
    def setpoint_velocity(self) -> np.ndarray:
        """(3,) indices of p_B,d' in x."""
        return self.base_state("v_d")

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
        """(k,) indices in x of what nobody measures; k = 0 in the models with K_B alone."""
        names = [name for name in HIDDEN_STATES if name in self.axis_states]
        return np.array([i for name in names for i in self.base_state(name)], dtype=int)

    def initial_state(
        self,
        p_B: np.ndarray,
        v_B: np.ndarray,
        base_setpoint: np.ndarray,
        joint_setpoint: np.ndarray,
        thrust: Thrust | None = None,
        last: np.ndarray | None = None,
    ) -> np.ndarray:
        """x_0 from measurement and command.

        The arm is where it is commanded (paper, section II-B), and so is the
        base of the integral model. Hidden states are where the last x leads
        under the acceleration that was commanded since.

        Args:
            p_B: (3,) m, measured.
            v_B: (3,) m/s, measured.
            base_setpoint: (9,) [p_d, v_d, a_d] in m, m/s, m/s^2, or (6,) of them
                where there is no `last`.
            joint_setpoint: (3 n,) [q_d, q_d', q_d''] in rad, rad/s, rad/s^2, or
                (2 n,) alike.
            thrust: Where the model has states of it; without, they are zero.
            last: (nx,) x_0 of the tick before; without, hidden states are zero.
        """
        is_known = last is not None and len(self.hidden) > 0
        return initial_state(
            self._places,
            p_B,
            v_B,
            base_setpoint,
            joint_setpoint,
            NO_THRUST if thrust is None else thrust,
            last if is_known else self._unknown,
            is_known,
        )

    @cached_property
    def _unknown(self) -> np.ndarray:
        return np.zeros(len(self.A))

    @cached_property
    def _velocity_rows(self) -> tuple[np.ndarray, np.ndarray]:
        """A and B of the base's velocity."""
        return self.A[self.base_velocity], self.B[self.base_velocity]

    def next_velocity(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """(3,) m/s, the base's velocity one period later without Delta.

        Args:
            x: (nx,) the state.
            u: (3 + n,) m/s^2 and rad/s^2.
        """
        A, B = self._velocity_rows
        return A @ x + B @ u

    def predict(self, x: np.ndarray, u: np.ndarray, delta: np.ndarray) -> np.ndarray:
        """(nx,) the state one period later.

        Args:
            x: (nx,) the state.
            u: (3 + n,) m/s^2 and rad/s^2.
            delta: (3,) m/s, Delta.
        """
        return self.A @ x + self.B @ u + self.C @ delta

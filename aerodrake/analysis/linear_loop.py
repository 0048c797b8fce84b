"""Linear system of a loop's period, with delays and gains in its signals."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import matrix_balance

from aerodrake.analysis.feedback import in_loop
from aerodrake.analysis.linearization import InstantJacobian, PeriodJacobian
from aerodrake.analysis.quiet_loop import QUARTERS
from aerodrake.analysis.sampled_system import SampledSystem

AXES, TURNS = ("x", "y", "z"), ("roll", "pitch", "yaw")

FORCES = tuple(f"force_{axis}" for axis in AXES)
TORQUES = tuple(f"torque_{axis}" for axis in AXES)
TOOL = tuple(f"tool_{axis}" for axis in AXES)

COUPLED = 1e-9
"""Least entry of A that connects two states; smaller ones are errors of the differences."""


class Variation(NamedTuple):
    """Change of signals in the loop.

    Attributes:
        delay_steps: Additional delay of the base's samples, in plant steps.
        rotor_gain: Factor on the deviation of the thrust commands from trim.
        joint_gain: Factor on the deviation of the joint torques from trim.
    """

    delay_steps: int = 0
    rotor_gain: float = 1.0
    joint_gain: float = 1.0


class PeriodMatrices(NamedTuple):
    """Matrices of one period: x[k+1] = A x[k] + B u[k], and the plant at its steps in between.

    Attributes:
        A: (nx, nx).
        B: (nx, nu).
        plant: (steps + 1, 12 + 2 n, nx), plant's state after each step, from 0 on, for u = 0.
        names: nx names of the states.
        dt: s, the period.
    """

    A: np.ndarray
    B: np.ndarray
    plant: np.ndarray
    names: tuple[str, ...]
    dt: float


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """Linear system of one period, for any variation of the loop.

    The product of the Jacobians of all instants gives the matrices. The state is that of the
    diagram, and past positions and velocities of the base as far as delayed samples need them.

    Attributes:
        period: The linearised period.
    """

    period: PeriodJacobian

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs: torque and force on the base, and noise of the samples."""
        noise = (
            *(f"attitude_noise_{turn}" for turn in TURNS),
            *(f"position_noise_{axis}" for axis in AXES),
            *(f"joint_noise_{joint}" for joint in self.period.joints),
            *(f"rate_noise_{axis}" for axis in AXES),
            *(f"velocity_noise_{axis}" for axis in AXES),
        )
        return (*TORQUES, *FORCES, *noise)

    @cached_property
    def nominal(self) -> PeriodMatrices:
        """The matrices without variation."""
        return self._looped(Variation())

    @cached_property
    def system(self) -> SampledSystem:
        """The system without variation; its output is the tool's position.

        It has the states on which the plant acts and that act on the plant.
        """
        A, B, _, names, _ = self.nominal
        C = np.zeros((len(TOOL), len(names)))
        C[:, [names.index(name) for name in self._positions]] = self.period.tool
        _, (scale, _) = matrix_balance(A, permute=False, separate=True)
        return SampledSystem(
            A=A,
            B=B,
            C=C,
            D=np.zeros((len(TOOL), len(self.inputs))),
            dt=self.period.dt,
            states=names,
            inputs=self.inputs,
            outputs=TOOL,
            state_scale=scale,
        )

    def matrices(self, variation: Variation) -> PeriodMatrices:
        """Returns the matrices of the loop with a variation.

        Their states are those on which the plant acts, and that act on the plant.
        """
        return self.nominal if variation == Variation() else self._looped(variation)

    def _looped(self, variation: Variation) -> PeriodMatrices:
        A, B, plant, names, _ = self._all_matrices(variation)
        keep = in_loop(np.abs(A) > COUPLED, self._plant)
        return PeriodMatrices(
            A[np.ix_(keep, keep)],
            B[keep],
            plant[:, :, keep],
            tuple(names[i] for i in keep),
            self.period.dt,
        )

    def _all_matrices(self, variation: Variation) -> PeriodMatrices:
        """Returns the matrices with all states of `period`.

        Times are in plant steps from the start of the period.
        """
        period, base = self.period, self._plant[self._in_base]
        sample, constant = self._coordinates("sampler", "state"), self._coordinates("disturbance")
        delay = period.delay_steps + variation.delay_steps
        names, times = period.coordinates.names, self._history(delay)
        n, b, noisy = len(names), len(base), 12 + len(period.joints)
        size = n + b * len(times)
        # Rows: the state, now. Columns: the state at the start of the period, and the noise.
        M = np.eye(size, size + noisy)
        past = {time: M[n + b * i : n + b * (i + 1)].copy() for i, time in enumerate(times)}
        past[0], plant = M[base], [M[self._plant]]
        for instant in period.instants:
            M[instant.rows] = self._varied(instant, variation) @ M[instant.columns]
            time, quarters = divmod(instant.instant, QUARTERS)
            if quarters == 0:
                past[time + 1] = M[base]
                plant.append(M[self._plant])
            if sample[0] in instant.rows:
                M[sample[self._in_base]] = past[time + 1 - delay]
                M[sample[:noisy], size:] += np.eye(noisy)
        if times:
            M[n:] = np.vstack([past[time + period.steps] for time in times])
        history = [
            f"base_delay.{names[i].partition('.')[2]}[{-time}]" for time in times for i in base
        ]
        keep = np.setdiff1d(np.arange(size), constant)
        inputs = np.concatenate([constant, np.arange(size, size + noisy)])
        names = np.array([*names, *history])[keep]
        return PeriodMatrices(
            M[np.ix_(keep, keep)],
            M[np.ix_(keep, inputs)],
            np.array(plant)[:, :, keep],
            tuple(map(str, names)),
            period.dt,
        )

    def _history(self, delay: int) -> list[int]:
        """Returns the times before the period at which the base's state is needed."""
        period, sample = self.period, self._coordinates("sampler", "state")[0]
        times = {
            time
            for instant in period.instants
            if sample in instant.rows
            for time in range(instant.instant // QUARTERS + 1 - delay, 0, period.steps)
        }
        return sorted(times)

    def _varied(self, instant: InstantJacobian, variation: Variation) -> np.ndarray:
        """Returns the Jacobian of an instant with the gains of a variation."""
        J = instant.J
        for target, source, gain in (
            ("rotors", ("flight_controller", "thrust_command"), variation.rotor_gain),
            ("plant", ("arm_controller", "joint_torque"), variation.joint_gain),
        ):
            if gain != 1.0:
                rows = np.isin(instant.rows, self._coordinates(target))
                columns = np.isin(instant.columns, self._coordinates(*source))
                J = np.where(np.outer(rows, columns), gain * J, J)
        return J

    def _coordinates(self, system: str, group: str = "") -> np.ndarray:
        """Returns the coordinates of a group."""
        part = self.period.coordinates.of_group(system, group)
        return np.arange(part.start, part.stop)

    @cached_property
    def _plant(self) -> np.ndarray:
        return self._coordinates("plant")

    @property
    def _positions(self) -> tuple[str, ...]:
        """Names of the 6 + n positions of the plant."""
        return tuple(self.period.coordinates.names[i] for i in self._plant[: len(self._plant) // 2])

    @property
    def _in_base(self) -> np.ndarray:
        """(12,) coordinates of the base within those of a `VehicleState`."""
        return np.add.outer([0, 6 + len(self.period.joints)], np.arange(6)).ravel()

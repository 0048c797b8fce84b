"""Linearisation of a loop's period as a product of Jacobians, one for each instant."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydrake.math import VectorToSkewSymmetric
from pydrake.systems.framework import DiscreteValues

from aerodrake.analysis.coordinates import StateCoordinates, StateGroup
from aerodrake.analysis.feedback import in_loop
from aerodrake.analysis.quiet_loop import QuietLoop
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state

Perturbation = Callable[[DiscreteValues], None]
"""Function that changes a state in place."""

STEP = 1e-6
"""Step of the central differences, in the unit of each coordinate."""

UNPERTURBED = frozenset({"base_delay"})
"""Systems whose state is known without differences: `LinearLoop` has delays of its own."""

INPUT = "disturbance"
"""System whose constant state is an input."""


@dataclass(frozen=True)
class InstantJacobian:
    """Influence of the coordinates on those that the events of one instant set.

    Attributes:
        instant: In quarters of a plant step from the multiple of the period.
        rows: (r,) coordinates that are set.
        columns: (c,) coordinates that have influence on them, and `rows`.
        J: (r, c).
    """

    instant: int
    rows: np.ndarray
    columns: np.ndarray
    J: np.ndarray


@dataclass(frozen=True)
class PeriodJacobian:
    """One linearised period of a loop.

    Attributes:
        coordinates: Coordinates of the groups in a loop with the plant, and of the inputs.
        instants: Jacobians of its instants, in order.
        dt: s, the period.
        steps: Number of plant steps in it.
        delay_steps: Delay of the base's samples, in plant steps.
        joints: Names of the n joints.
        fastest: Largest velocity of base and joints at its start, in m/s and rad/s.
        tool: (3, 6 + n) Jacobian of the tool's position in the world with respect to the
            positions of the plant, at the start of the period.
    """

    coordinates: StateCoordinates
    instants: tuple[InstantJacobian, ...]
    dt: float
    steps: int
    delay_steps: int
    joints: tuple[str, ...]
    fastest: float
    tool: np.ndarray


class Linearizer:
    """Linearises one period of a loop about its trajectory from the present Context on.

    Central differences average the sides of a function with a kink at the trajectory.

    Args:
        loop: Its Context is at the start of a period.
        multiple: Number of the period.
    """

    def __init__(self, loop: QuietLoop, multiple: int):
        self._loop, self._multiple = loop, multiple
        names = loop.vehicle.joint_names
        self._all = StateCoordinates.of(loop.diagram, loop.snapshot(), names)
        self._snapshots, self._fastest = [loop.snapshot()], loop.fastest()
        for interval in loop.intervals:
            loop.advance(loop.time_s(multiple, interval.end))
            self._snapshots.append(loop.snapshot())
        self._values = [
            [values.value(group.index).copy() for group in self._all.groups]
            for values in self._snapshots
        ]

    def run(self) -> PeriodJacobian:
        """Returns the Jacobians; the Context is at the end of the period afterwards."""
        loop = self._loop
        influences = self._influences()
        relevant = self._relevant(np.any([*influences.values()], axis=0))
        coordinates = StateCoordinates(tuple(self._all.groups[i] for i in relevant))
        jacobians = tuple(
            self._jacobian(k, coordinates, influence)
            for k, interval in enumerate(loop.intervals)
            if (influence := influences[interval.events][np.ix_(relevant, relevant)]).any()
        )
        loop.restore(self._snapshots[-1], loop.time_s(self._multiple, loop.intervals[-1].end))
        rates, delay_s = loop.scenario.rates, loop.scenario.sensors.base_delay_s
        return PeriodJacobian(
            coordinates=coordinates,
            instants=jacobians,
            dt=loop.period_s,
            steps=round(loop.period_s / rates.plant_step_s),
            delay_steps=round(delay_s / rates.plant_step_s),
            joints=loop.vehicle.joint_names,
            fastest=self._fastest,
            tool=self._tool_jacobian(),
        )

    def _influences(self) -> dict[frozenset[int], np.ndarray]:
        """Returns for each kind of instant which groups (rows) act on which (columns).

        Only groups on which the plant acts, directly or not, and inputs have entries. All
        coordinates of a group are perturbed at once. The events are deterministic: without
        influence, results are the same to the last bit.
        """
        groups = self._all.groups
        kinds = {interval.events: k for k, interval in reversed([*enumerate(self._loop.intervals)])}
        influences = {events: np.zeros((len(groups),) * 2, dtype=bool) for events in kinds}
        queue = [i for i, group in enumerate(groups) if group.system in ("plant", INPUT)]
        for i in queue:  # Grows.
            for events, k in kinds.items():
                acts = influences[events][i]
                acts[:] = self._acts(k, groups[i], i)
                queue += [j for j in np.flatnonzero(acts) if j not in queue]
        return influences

    def _acts(self, k: int, group: StateGroup, own: int) -> np.ndarray:
        """Returns a mask of the groups on which one acts in the interval k.

        Its own entry is True if the group is set in the interval.
        """
        groups, nominal = self._all.groups, self._values[k + 1]
        if group.system in UNPERTURBED:
            return np.zeros(len(groups), dtype=bool)
        step = STEP * np.random.default_rng(0).uniform(0.5, 1.0, group.size)
        after = self._perturbed(k, partial(group.perturb, step=step))
        values = [after.value(other.index) for other in groups]
        acts = [
            not np.array_equal(*pair, equal_nan=True) for pair in zip(values, nominal, strict=True)
        ]
        kept = group.difference(values[own], nominal[own])
        acts[own] = not np.allclose(kept, step, rtol=0, atol=1e-3 * STEP)
        return np.array(acts)

    def _relevant(self, acts: np.ndarray) -> np.ndarray:
        """Returns the indices of the groups in a loop with the plant, and of the inputs."""
        systems = np.array([group.system for group in self._all.groups])
        plant, inputs = (np.flatnonzero(systems == name) for name in ("plant", INPUT))
        return np.union1d(in_loop(acts, plant), inputs)

    def _jacobian(
        self, k: int, coordinates: StateCoordinates, influence: np.ndarray
    ) -> InstantJacobian:
        sets = np.flatnonzero(influence.any(axis=0))
        acts = sorted({*np.flatnonzero(influence.any(axis=1)), *sets})
        index = np.arange(len(coordinates.names))
        rows, columns = (
            np.concatenate([index[coordinates.slices[i]] for i in part]) for part in (sets, acts)
        )
        targets = [coordinates.groups[i] for i in sets]
        J = []
        for i in acts:
            group = coordinates.groups[i]
            for step in STEP * np.eye(group.size):
                plus, minus = (
                    self._differences(k, partial(group.perturb, step=s), targets)
                    for s in (step, -step)
                )
                J.append((plus - minus) / (2 * STEP))
        return InstantJacobian(self._loop.intervals[k].instant, rows, columns, np.array(J).T)

    def _tool_jacobian(self) -> np.ndarray:
        loop = self._loop
        plant = [group.system for group in self._all.groups].index("plant")
        state = split_state(self._values[0][plant])
        tool = Kinematics(loop.vehicle.plant).end_effector(state)
        turn = -state.R_B @ VectorToSkewSymmetric(tool.p_EB)
        return np.hstack([turn, np.eye(3), state.R_B @ tool.J_B])

    def _differences(
        self, k: int, perturb: Perturbation, targets: Sequence[StateGroup]
    ) -> np.ndarray:
        """Returns the change (r,) of the targets after the events of a perturbed interval k."""
        after, nominal = self._perturbed(k, perturb), self._snapshots[k + 1]
        return np.concatenate(
            [t.difference(after.value(t.index), nominal.value(t.index)) for t in targets]
        )

    def _perturbed(self, k: int, perturb: Perturbation) -> DiscreteValues:
        """Returns the state after the events of the interval k, which starts perturbed."""
        loop, interval = self._loop, self._loop.intervals[k]
        loop.restore(self._snapshots[k], loop.time_s(self._multiple, interval.start))
        perturb(loop.context.get_mutable_discrete_state())
        loop.advance(loop.time_s(self._multiple, interval.end))
        return loop.context.get_discrete_state()

"""The MPC's ticks as they came in a flight, and their replay against the clock."""

from __future__ import annotations

import copy
import gc
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from aerodrake.bench.peers import Peer
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation, MpcProgram
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.condensed_qp import QpResult, QpStatus, is_constrained
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.threads import single_thread

OWN = "aerodrake"
"""The name among the solvers of the one that flies."""

SLOW_MS = 3.0
"""A peer whose first pass has a longer median than this is spared the others."""

UNMEASURED = 5
"""Ticks that are solved before a clock runs: for what compiles and fills caches first."""


@dataclass(frozen=True)
class RecordedTicks:
    """The ticks of one flight, in their order.

    Attributes:
        formulation: Forms their programs.
        inputs: What each tick was about.
    """

    formulation: MpcFormulation
    inputs: list[MpcInputs]


@dataclass(frozen=True)
class Replay:
    """What a replay of K ticks took and said.

    Attributes:
        forming_ms: By solver, (K,), the least of all passes: of each program, and for all but
            the solver that flies of its H. That one forms H as it solves, where it needs it.
        solving_ms: By solver, (K,), the least of its passes.
        u_0: By solver, (K, 3 + n) m/s^2 and rad/s^2, the first inputs.
        statuses: (K,), those of the solver that flies.
    """

    forming_ms: Mapping[str, np.ndarray]
    solving_ms: Mapping[str, np.ndarray]
    u_0: Mapping[str, np.ndarray]
    statuses: list[QpStatus]

    def tick_ms(self, solver: str) -> np.ndarray:
        """(K,), forming and solving."""
        return self.forming_ms[solver] + self.solving_ms[solver]


def record_ticks(scenario: Scenario) -> RecordedTicks:
    """Flies a scenario and keeps what its MPC was asked at each tick."""
    flight = FlightSimulation(scenario)
    mpc = flight.closed_loop.GetSubsystemByName("coordinator").GetSubsystemByName("mpc")
    inputs: list[MpcInputs] = []
    answer = mpc.tick_inputs

    def recorded(context: object) -> MpcInputs:
        tick = answer(context)
        inputs.append(copy.deepcopy(tick))
        return tick

    mpc.tick_inputs = recorded
    flight.fly()
    vehicle = VehicleModel.load(scenario)
    model = EquivalentModel.of(scenario, vehicle.joints)
    limits = SetpointLimits.make(scenario.mpc, vehicle)
    formulation = MpcFormulation(scenario.mpc, model, limits, vehicle)
    return RecordedTicks(formulation, inputs)


def replay(
    recorded: RecordedTicks, peers: Mapping[str, Callable[[np.ndarray], Peer]], passes: int
) -> Replay:
    """Solves recorded ticks anew, tick by tick with every solver, on one thread.

    A pass goes through the ticks in the flight's order, so that warm
    starts are those of the flight. A tick's program is formed, and solved by each
    solver in an order that rotates from tick to tick. Of what a tick takes in the
    passes the least counts: the rest is what else the machine does.

    Args:
        recorded: The ticks.
        peers: Makers of solvers from A (rows, nz), by name, beside the one that flies.
        passes: How many, for all but slow peers.
    """
    formulation, inputs = recorded.formulation, recorded.inputs
    names = [OWN, *peers]
    forming, solving = ({name: np.full(len(inputs), np.inf) for name in names} for _ in range(2))
    answers: dict[str, list[np.ndarray]] = {name: [] for name in names}
    statuses: list[QpStatus] = []
    with single_thread(), _no_garbage_collection():
        for number in range(passes):
            slow = {n for n in peers if number and np.median(solving[n]) > SLOW_MS}
            fast = [name for name in names if name not in slow]
            solvers = {n: peers[n](formulation.A).solve for n in fast if n != OWN}
            solvers[OWN] = _Own(formulation).solve
            if not number:
                _warm_up(recorded, solvers)
            for k, tick in enumerate(inputs):
                start = time.perf_counter()
                program = formulation.form(tick)
                formed = time.perf_counter()
                _ = program.H  # Formed as it is asked for.
                complete = time.perf_counter()
                shift = k % len(fast)
                for name in (*fast[shift:], *fast[:shift]):
                    is_own = name == OWN
                    took = 1e3 * ((formed if is_own else complete) - start)
                    forming[name][k] = min(forming[name][k], took)
                    # Without what others have computed of it, or spoilt.
                    given = (replace(program),) if is_own else program_arrays(program)
                    solve_start = time.perf_counter()
                    answer = solvers[name](*given)
                    solved = 1e3 * (time.perf_counter() - solve_start)
                    solving[name][k] = min(solving[name][k], solved)
                    if number:
                        continue
                    if name == OWN:
                        statuses.append(answer.status)
                        answer = answer.z
                    answers[name].append(formulation.inputs(answer)[0])
    u_0 = {name: np.array(values) for name, values in answers.items()}
    return Replay(forming, solving, u_0, statuses)


class _Own:
    """The solver that flies, fed from tick to tick as `MpcSystem` does."""

    def __init__(self, formulation: MpcFormulation):
        self._solver = MpcSolver(formulation)
        self._active: np.ndarray | None = None

    def solve(self, program: MpcProgram) -> QpResult:
        result = self._solver.solve(program, self._active)
        self._active = result.active if is_constrained(result.status) else None
        return result


def _warm_up(recorded: RecordedTicks, solvers: Mapping[str, Callable[..., object]]) -> None:
    """Lets every solver compile what it has to before a clock runs."""
    for tick in recorded.inputs[:UNMEASURED]:
        program = recorded.formulation.form(tick)
        for name, solve in solvers.items():
            solve(*((program,) if name == OWN else program_arrays(program)))


def program_arrays(program: MpcProgram) -> tuple[np.ndarray, ...]:
    """(H, g, lower, upper), copied: no solver can spoil them for the next one."""
    return tuple(np.array(part) for part in (program.H, program.g, program.lower, program.upper))


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """As `timeit` does: a collection belongs to no tick."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()

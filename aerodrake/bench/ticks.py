"""Recorded MPC ticks of a flight, and their replay with several solvers."""

import copy
import gc
import time
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from aerodrake.bench.peers import Peer
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import QpStatus
from aerodrake.scenario import Scenario
from aerodrake.support.threads import single_thread

OWN = "aerodrake"
"""Name of the MPC's solver with the scenario's settings."""

SLOW_MS = 3.0
"""Largest median of a solver's first pass with which it takes part in further passes."""

UNMEASURED = 5
"""Number of ticks that are solved before the measurement, to compile and to fill caches."""


@dataclass(frozen=True)
class RecordedTicks:
    """Ticks of one flight, in order.

    Attributes:
        formulation: Forms their programs.
        inputs: Inputs of each tick.
    """

    formulation: MpcFormulation
    inputs: list[MpcInputs]


@dataclass(frozen=True)
class Replay:
    """Times and solutions of a replay of K ticks.

    Attributes:
        forming_ms: By solver, (K,), least time of all passes to form each program. For peers
            it includes H, which the MPC's solvers form only if they need it.
        solving_ms: By solver, (K,), least time of its passes.
        u_0: By solver, (K, 3 + n) m/s^2 and rad/s^2, the first inputs.
        statuses: By solver of the MPC, (K,).
    """

    forming_ms: Mapping[str, np.ndarray]
    solving_ms: Mapping[str, np.ndarray]
    u_0: Mapping[str, np.ndarray]
    statuses: Mapping[str, list[QpStatus]]

    def tick_ms(self, solver: str) -> np.ndarray:
        """Returns the times (K,) of forming and solving."""
        return self.forming_ms[solver] + self.solving_ms[solver]


def record_ticks(scenario: Scenario) -> RecordedTicks:
    """Flies a scenario and records the inputs of each MPC tick."""
    flight = FlightSimulation(scenario)
    mpc = flight.closed_loop.GetSubsystemByName("coordinator").GetSubsystemByName("mpc")
    inputs: list[MpcInputs] = []
    tick_inputs = mpc.tick_inputs

    def recorded(context: object) -> MpcInputs:
        tick = tick_inputs(context)
        inputs.append(copy.deepcopy(tick))
        return tick

    mpc.tick_inputs = recorded
    flight.fly()
    return RecordedTicks(mpc.formulation, inputs)


def replay(
    recorded: RecordedTicks,
    peers: Mapping[str, Callable[[np.ndarray], Peer]],
    passes: int,
    variants: Mapping[str, Mapping[str, object]] = MappingProxyType({}),
) -> Replay:
    """Solves recorded ticks again, tick by tick with every solver, on one thread.

    Each pass goes through the ticks in the order of the flight, so that warm starts are those
    of the flight. The order of the solvers rotates from tick to tick. The least time of all
    passes is used, to exclude other load of the machine.

    Args:
        recorded: The ticks.
        peers: Makers of solvers from A (rows, nz), by name, beside the MPC's own.
        passes: Number of passes; slow solvers but the MPC's own take part in the first one only.
        variants: Further solvers of the MPC by name: changes of the section `mpc`.
    """
    formulation, inputs = recorded.formulation, recorded.inputs
    own = {OWN: formulation.config}
    own |= {name: replace(formulation.config, **changes) for name, changes in variants.items()}
    names = [*own, *peers]
    forming, solving = ({name: np.full(len(inputs), np.inf) for name in names} for _ in range(2))
    u_0: dict[str, list[np.ndarray]] = {name: [] for name in names}
    statuses: dict[str, list[QpStatus]] = {name: [] for name in own}
    with single_thread(), _no_garbage_collection():
        for number in range(passes):
            slow = {n for n in names if number and np.median(solving[n]) > SLOW_MS} - {OWN}
            fast = [name for name in names if name not in slow]
            solvers = {n: peers[n](formulation.A).solve for n in fast if n in peers}
            solvers |= {n: MpcSolver.make(formulation, own[n]).solve for n in fast if n in own}
            if not number:
                _warm_up(recorded, solvers, peers)
            for k, tick in enumerate(inputs):
                program, own_ms, peer_ms = _timed_program(formulation, tick)
                shift = k % len(fast)
                for name in (*fast[shift:], *fast[:shift]):
                    formed_ms = peer_ms if name in peers else own_ms
                    forming[name][k] = min(forming[name][k], formed_ms)
                    given = _given(program, name in peers)
                    start = time.perf_counter()
                    solution = solvers[name](*given)
                    solved_ms = 1e3 * (time.perf_counter() - start)
                    solving[name][k] = min(solving[name][k], solved_ms)
                    if number:
                        continue
                    if name in own:
                        statuses[name].append(solution.status)
                        solution = solution.z
                    u_0[name].append(formulation.inputs(solution)[0])
    return Replay(forming, solving, {n: np.array(values) for n, values in u_0.items()}, statuses)


def _timed_program(formulation: MpcFormulation, tick: MpcInputs) -> tuple[MpcProgram, float, float]:
    """Returns the program of a tick and the times in ms to form it without and with H."""
    start = time.perf_counter()
    program = formulation.form(tick)
    own_ms = 1e3 * (time.perf_counter() - start)
    _ = program.H
    return program, own_ms, 1e3 * (time.perf_counter() - start)


def _given(program: MpcProgram, is_peer: bool) -> tuple[Any, ...]:
    """Returns what a solver receives: copies, so that solvers share nothing."""
    return program_arrays(program) if is_peer else (replace(program),)


def _warm_up(
    recorded: RecordedTicks, solvers: Mapping[str, Callable[..., object]], peers: Container[str]
) -> None:
    """Solves the first ticks with every solver, to compile before the measurement."""
    for tick in recorded.inputs[:UNMEASURED]:
        program = recorded.formulation.form(tick)
        for name, solve in solvers.items():
            solve(*_given(program, name in peers))


def program_arrays(program: MpcProgram) -> tuple[np.ndarray, ...]:
    """Returns copies of (H, g, lower, upper), which a solver may overwrite."""
    return tuple(np.array(part) for part in (program.H, program.g, program.lower, program.upper))


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Disables garbage collection during a measurement, as `timeit` does."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()

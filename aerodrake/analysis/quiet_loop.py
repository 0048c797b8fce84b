"""Closed loop without noise, gusts and learning, whose trajectory can be linearised."""

import math
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, DiscreteValues, System
from pydrake.systems.primitives import Adder, AffineSystem, ConstantVectorSource

from aerodrake.flight.simulate import MONITORED
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.station import RATES, add_closed_loop
from aerodrake.systems.mpc import MpcSystem
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring

OUTPUTS = (*MONITORED, "torque_at_limit", "thrust_command")
"""Outputs of station and coordinator that an analysis reads."""

QUARTERS = 4
"""Number of parts of a plant step in which offsets of events are counted."""

START = -1.5
"""Start of a period relative to a multiple of it, in quarters of a plant step: after the last plant
step, before the first sample."""


class EventInterval(NamedTuple):
    """Part of a period that contains the events of one instant.

    Attributes:
        start, end: Relative to the period's multiple, in quarters of a plant step.
        instant: The instant, likewise.
        events: Rows of `RATES` with events at the instant.
    """

    start: float
    end: float
    instant: int
    events: frozenset[int]


class SwitchedSolver(MpcSolver):
    """Solver of the MPC's programs that can ignore their bounds.

    Attributes:
        is_constrained: False for the unconstrained minimiser.
    """

    is_constrained = True

    def solve(self, program: MpcProgram) -> QpResult:
        if self.is_constrained:
            return super().solve(program)
        return QpResult(program.minimiser, QpStatus.UNCONSTRAINED)


class QuietLoop:
    """Closed loop of a scenario in a Context, to be simulated from and to any state.

    It differs from the scenario's:

    - samples have no noise, and the wind no gusts;
    - the only flaw of the sensors is their known delay, and the filter uses no accelerometer;
    - actuators have no levels, Coulomb friction, backlash and sag, and messages with setpoints the
      mean latency;
    - rotors rise and fall with the mean of both time constants. In an oscillation about a constant
      mean, a rotor spends the same time rising as falling, and its first harmonic is that of this
      lag up to 2 %;
    - the last layer of the residual network is constant;
    - the MPC solves its programs without bounds if `is_constrained` is False;
    - a constant force and torque can act on the base;
    - the hover before reference time 0 is longer, if necessary.

    Attributes:
        scenario: The scenario as simulated.
        vehicle: Its vehicle.
        diagram: Station and coordinator.
        context: Its Context, initially in trim.
        period_s: s, least common multiple of all periods: that of the MPC, if the others divide it.

    Args:
        scenario: The scenario to analyse.
        settle_s: s, least duration of the hover before reference time 0.
    """

    def __init__(self, scenario: Scenario, settle_s: float):
        rotor, wind = scenario.vehicle.rotor, scenario.wind
        lag_s = (rotor.lag_up_s + rotor.lag_down_s) / 2
        rotor = replace(rotor, lag_up_s=lag_s, lag_down_s=lag_s)
        self.scenario = scenario = replace(
            scenario,
            settle_s=max(scenario.settle_s, settle_s),
            sensors=scenario.sensors.without_flaws,
            filter=replace(scenario.filter, accelerometer_noise_m_s2=0.0),
            actuation=scenario.actuation.linear,
            vehicle=replace(scenario.vehicle, rotor=rotor),
            wind=replace(wind, gust_m_s=(0.0,) * len(wind.gust_m_s)),
            residual=replace(scenario.residual, learning_rate=0.0),
        )
        self.vehicle = VehicleModel.load(scenario)
        step_s = scenario.rates.plant_step_s
        periods = [round(getattr(scenario.rates, rate.period) / step_s) for rate in RATES]
        self.period_s = math.lcm(*periods) * step_s
        self._solvers: list[SwitchedSolver] = []
        builder = DiagramBuilder()
        by_name = {"sensor_noise": _silent, "pushes": self._disturbed}
        if scenario.controller == "mpc":
            by_name["mpc"] = self._switched
        if max(scenario.actuation.setpoint_latency_s) > 0:
            by_name["setpoint_draws"] = _silent
        replacements = Replacements(by_name)
        ports = add_closed_loop(builder, scenario, replacements, None, self.vehicle)
        for name in OUTPUTS:
            builder.ExportOutput(ports[name], name)
        self.diagram: Diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self._simulator = Simulator(self.diagram, self.context)
        self._simulator.Initialize()
        self._initial = self.snapshot()
        self._quiet = InitializeParams()
        self._quiet.suppress_initialization_events = True

    def output(self, name: str) -> np.ndarray:
        """Returns the value (...,) of one of `OUTPUTS`."""
        return self.diagram.GetOutputPort(name).Eval(self.context).copy()

    def fastest(self) -> float:
        """Returns the largest velocity of base and joints, in m/s and rad/s."""
        state = split_state(self.output("true_state"))
        return float(np.abs(np.concatenate([state.omega_W, state.v_B, state.qdot])).max())

    @property
    def is_constrained(self) -> bool:
        """False if the MPC ignores its bounds."""
        return all(solver.is_constrained for solver in self._solvers)

    @is_constrained.setter
    def is_constrained(self, value: bool) -> None:
        for solver in self._solvers:
            solver.is_constrained = value

    @property
    def quarter_s(self) -> float:
        """s, a quarter of a plant step."""
        return self.scenario.rates.plant_step_s / QUARTERS

    @cached_property
    def intervals(self) -> tuple[EventInterval, ...]:
        """The intervals of one period, in order."""
        rates, end = self.scenario.rates, round(self.period_s / self.quarter_s)
        events: dict[int, set[int]] = {}
        for row, rate in enumerate(RATES):
            period = round(getattr(rates, rate.period) / self.quarter_s)
            offset = round(QUARTERS * rate.offset_steps)
            first = offset + period * math.ceil((START - offset) / period)
            for instant in range(first, math.floor(end + START) + 1, period):
                events.setdefault(instant, set()).add(row)
        instants = sorted(events)
        inner = [(a + b) / 2 for a, b in zip(instants[:-1], instants[1:], strict=True)]
        bounds = [START, *inner, end + START]
        return tuple(
            EventInterval(bounds[i], bounds[i + 1], instant, frozenset(events[instant]))
            for i, instant in enumerate(instants)
        )

    def time_s(self, multiple: int, quarters: float) -> float:
        """Returns the time at a multiple of the period plus quarters of a plant step."""
        return multiple * self.period_s + quarters * self.quarter_s

    def multiple(self, time_s: float) -> int:
        """Returns the number of the period whose start is nearest to a time."""
        return round(time_s / self.period_s)

    def start_s(self, multiple: int) -> float:
        """Returns the time at which a period starts."""
        return self.time_s(multiple, START)

    def reset(self) -> None:
        """Returns to trim at time 0."""
        self.restore(self._initial, 0.0)

    def advance(self, time_s: float) -> None:
        """Simulates from the Context's present time and state.

        Raises:
            Exception: as the Simulator does, such as for a state that is not finite.
        """
        self._simulator.Initialize(self._quiet)
        self._simulator.AdvanceTo(time_s)

    def snapshot(self) -> DiscreteValues:
        """Returns a copy of the state."""
        values = self.diagram.AllocateDiscreteVariables()
        values.SetFrom(self.context.get_discrete_state())
        return values

    def restore(self, values: DiscreteValues, time_s: float) -> None:
        """Sets time and state."""
        self.context.SetTime(time_s)
        self.context.get_mutable_discrete_state().SetFrom(values)

    def _switched(self, mpc: System) -> System:
        formulation: MpcFormulation = mpc.formulation
        solver = SwitchedSolver.make(formulation, formulation.config)
        self._solvers.append(solver)
        return MpcSystem(formulation, solver)

    def _disturbed(self, pushes: System) -> System:
        """Returns the pushes with a constant force and torque, in the world, on the base."""
        builder = DiagramBuilder()
        builder.AddNamedSystem("faults", pushes)
        size = pushes.get_output_port().size()
        # Constant: x' = x. Its state is a force that lasts over a whole period.
        hold = AffineSystem(A=np.eye(6), C=np.eye(size, 6), time_period=self.period_s)
        builder.AddNamedSystem("disturbance", hold)
        builder.AddNamedSystem("sum", Adder(2, size))
        return Wiring(
            connections=(("faults", "y0", "sum", "u0"), ("disturbance", "y0", "sum", "u1")),
            outputs=(("sum", "sum", "y0"),),
        ).build(builder, "pushes")


def _silent(noise: System) -> System:
    """Returns a source of zeros with the port of a noise source."""
    builder = DiagramBuilder()
    zeros = ConstantVectorSource(np.zeros(noise.GetOutputPort("output").size()))
    builder.ExportOutput(builder.AddNamedSystem("zeros", zeros).get_output_port(), "output")
    return builder.Build()

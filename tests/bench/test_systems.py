"""The stopwatch: exclusive times by system, and no effect on the flight."""

import time

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from aerodrake.bench import systems as bench_systems
from aerodrake.bench.systems import DECLARATIONS, timed_systems
from aerodrake.flight.simulate import FlightSimulation

PULL_S, UPDATE_S = 0.25, 1.0


class Source(LeafSystem):
    def __init__(self, clock):
        super().__init__()
        self._clock = clock
        self.DeclareVectorOutputPort("out", 1, self._calc, {self.time_ticket()})

    def _calc(self, context, output):
        self._clock[0] += PULL_S
        output.SetFromVector([context.get_time()])


class Sink(LeafSystem):
    def __init__(self, clock):
        super().__init__()
        self._clock = clock
        self._in = self.DeclareVectorInputPort("in", 1)
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(0.1, 0.0, self._update)

    def _update(self, context, discrete):
        self._clock[0] += UPDATE_S
        discrete.set_value(0, self._in.Eval(context))


def test_an_evaluated_port_counts_for_the_system_that_computes_it(monkeypatch):
    clock = [0.0]
    Source.__module__, Sink.__module__ = "a.source", "a.sink"
    monkeypatch.setattr(bench_systems.time, "perf_counter", lambda: clock[0])
    with timed_systems() as seconds:
        builder = DiagramBuilder()
        source, sink = builder.AddSystem(Source(clock)), builder.AddSystem(Sink(clock))
        builder.Connect(source.get_output_port(), sink.get_input_port())
        simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.95)
    assert seconds["sink"] == pytest.approx(10 * UPDATE_S)
    assert seconds["source"] == pytest.approx(PULL_S * round(seconds["source"] / PULL_S))
    assert 0 < seconds["source"] <= 10 * PULL_S
    assert clock[0] == pytest.approx(sum(seconds.values()))


def test_leafsystem_is_restored():
    before = [getattr(LeafSystem, name) for name in DECLARATIONS]
    with pytest.raises(ZeroDivisionError), timed_systems():
        assert [getattr(LeafSystem, name) for name in DECLARATIONS] != before
        _ = 1 / 0
    assert [getattr(LeafSystem, name) for name in DECLARATIONS] == before


def test_a_timed_flight_is_the_same_flight(short_flight):
    scenario, log = short_flight
    with timed_systems() as seconds:
        flight = FlightSimulation(scenario)
    start = time.perf_counter()
    timed = flight.fly()
    whole = time.perf_counter() - start
    for key, values in log.signals.items():
        if not key.endswith("_ms"):
            np.testing.assert_array_equal(timed[key], values)
    # All Python systems, and no more than the whole time.
    assert set(seconds) >= {
        "mpc", "flight_controller", "arm_controller", "reference", "kinematics", "sensors",
        "weight_allocator", "residual_estimator", "setpoint_integrator", "equivalent_state",
    }  # fmt: skip
    assert all(s > 0 for s in seconds.values())
    assert 1e-3 * timed["tick_ms"].sum() < seconds["mpc"] < sum(seconds.values()) < whole

"""Faults of samples as systems: start and end, combinations, and in flight."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import (
    SAMPLE_GROUPS,
    SampleFault,
    SampleFrozen,
    SampleJump,
    SampleNan,
    SampleStale,
)
from aerodrake.scenario.load import load_scenario
from aerodrake.systems.faults.samples import SampleFaultSystem

JOINTS = 6
SIZE = VehicleState.size(JOINTS)
PERIOD, SETTLE = 0.01, 3.0
KINDS = (SampleNan, SampleStale, SampleFrozen, SampleJump)


def arriving(*faults: SampleFault, until: float = 3.2) -> tuple[np.ndarray, ...]:
    """Returns times, and samples and stamps after faults; all values equal the time in s."""
    builder = DiagramBuilder()
    clock = PiecewisePolynomial.FirstOrderHold([0, 10], [[0, 10]] * (SIZE + 3))
    samples, stamps = (
        builder.AddSystem(TrajectorySource(clock.Block(0, 0, rows, 1))) for rows in (SIZE, 3)
    )
    ports = samples.get_output_port(), stamps.get_output_port()
    for fault in faults:
        system = builder.AddSystem(SampleFaultSystem(fault, SETTLE, PERIOD, SIZE))
        for i, port in enumerate(ports):
            builder.Connect(port, system.get_input_port(i))
        ports = system.GetOutputPort("sample"), system.GetOutputPort("stamps")
    for port in ports:
        builder.ExportOutput(port)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    rows = []
    for k in range(round(until / PERIOD)):
        simulator.AdvanceTo(k * PERIOD)
        values = [diagram.get_output_port(i).Eval(simulator.get_context()) for i in range(2)]
        rows.append((k * PERIOD, *values))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("start", "duration"), [(0.05, 0.1), (-0.07, 0.05), (0.1, 0.0)])
def test_a_fault_lasts_from_its_start_until_just_before_its_end(kind, start, duration):
    """In reference time, to the sample."""
    times, samples, _ = arriving(kind(start_s=start, duration_s=duration))
    healthy = np.all(np.abs(samples - times[:, None]) < 1e-9, axis=1)
    k = np.arange(len(times))
    first, end = round((SETTLE + start) / PERIOD), round((SETTLE + start + duration) / PERIOD)
    # Held values are those of the sample before the fault: the first faulty sample differs.
    np.testing.assert_array_equal(healthy, (k < first) | (k >= end))


@pytest.mark.parametrize("kind", [SampleStale, SampleFrozen])
def test_the_last_sample_before_a_fault_is_held(kind):
    _, samples, stamps = arriving(kind(start_s=0.0, duration_s=0.1))
    np.testing.assert_allclose(samples[300:310], 2.99)
    np.testing.assert_allclose(stamps[305], 2.99 if kind is SampleStale else 3.05)


def test_faults_compose_in_their_order():
    """A frozen jump outlasts the jump; a jump of a frozen sample does not."""
    jump = SampleJump(group="joints", start_s=0.0, duration_s=0.1, angle_rad=1.0)
    freeze = SampleFrozen(group="joints", start_s=0.05, duration_s=0.1)
    q = slice(7, 7 + JOINTS)
    _, jumped_first, _ = arriving(jump, freeze)
    np.testing.assert_allclose(jumped_first[312][q], 3.04 + 1.0)
    _, frozen_first, _ = arriving(freeze, jump)
    np.testing.assert_allclose(frozen_first[307][q], 3.04 + 1.0)
    np.testing.assert_allclose(frozen_first[312][q], 3.04)


@pytest.mark.parametrize("group", ["position", "attitude", "joints", "all"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_short_fault_does_not_affect_the_flight(kind, group):
    """For 0.1 s during a flight with noise and gusts."""
    scenario = replace(
        load_scenario("clover_realistic"),
        settle_s=0.5,
        duration=1.5,
        faults=(kind(group=group, start_s=0.5, duration_s=0.1, position_m=3.0, angle_rad=2.0),)
        if kind is SampleJump
        else (kind(group=group, start_s=0.5, duration_s=0.1),),
    )
    log = FlightSimulation(scenario).fly()
    assert log.exit_reason == "completed"
    for key, values in log.signals.items():
        assert np.isfinite(values).all(), key
    is_rejected = log["sample_verdict"][(log.time_s > 0.55) & (log.time_s < 0.6)].any(axis=0)
    assert list(is_rejected) == [group in (name, "all") for name in SAMPLE_GROUPS]
    # 5 mm without a fault.
    assert log.error_m.max() < 0.02

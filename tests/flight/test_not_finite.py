"""Tests of flights that end with NaN or infinity, and of the port that they name."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
    System,
)

from aerodrake.flight.not_finite import not_finite
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize, to_json
from aerodrake.scenario import Clover, SampleNan, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from aerodrake.support.errors import BadInput
from aerodrake.wiring.replacements import Replacements

SHORT = Scenario(duration=0.5, settle_s=0.1, reference=Clover(start_s=0.2))


class Corruption(LeafSystem):
    """Outputs its input; from the time `after_s` on, `number` is its last entry."""

    def __init__(self, size: int, number: float, after_s: float):
        super().__init__()
        self.set_name("corruption")
        self.number, self.after_s = number, after_s
        self.DeclareVectorInputPort("original", size)
        self.DeclareVectorOutputPort("corrupted", size, self._calc)

    def _calc(self, context: Context, output: BasicVector) -> None:
        value = self.get_input_port().Eval(context).copy()
        if context.get_time() >= self.after_s:
            value[-1] = self.number
        output.SetFromVector(value)


def corrupted(port: str, number: float, after_s: float):
    """Replaces a system by itself, with the output `port` corrupted."""

    def make(ours: System) -> Diagram:
        builder = DiagramBuilder()
        inner = builder.AddNamedSystem("inside", ours)
        for i in range(inner.num_input_ports()):
            builder.ExportInput(inner.get_input_port(i), inner.get_input_port(i).get_name())
        for i in range(inner.num_output_ports()):
            out = end = inner.get_output_port(i)
            if out.get_name() == port:
                corruption = builder.AddSystem(Corruption(out.size(), number, after_s))
                builder.Connect(out, corruption.get_input_port())
                end = corruption.get_output_port()
            builder.ExportOutput(end, out.get_name())
        return builder.Build()

    return make


@pytest.mark.parametrize(
    ("name", "port", "path"),
    [
        ("flight_controller", "thrust_command", "station::flight_controller::corruption"),
        ("arm_controller", "joint_torque", "station::arm_controller::corruption"),
        ("wind", "generalized_force", "station::physics::wind::corruption"),
        ("sensors", "state", "station::sensors::corruption"),
        ("mpc", "u", "coordinator::mpc::corruption"),
        ("supervisor", "mode", "coordinator::supervisor::corruption"),
    ],
)
def test_the_port_is_named(name, port, path):
    flight = FlightSimulation(SHORT, Replacements({name: corrupted(port, np.nan, after_s=0.35)}))
    log = flight.fly()
    assert log.exit_reason == "lost"
    assert log.exit_cause.startswith(f"{path}: corrupted not finite at 0.")
    assert "Failure at" not in log.exit_cause  # The path of Drake's source file.
    assert 0.23 <= log.time_s[-1] <= 0.31
    assert to_json(summarize(SHORT, log))


def test_from_the_first_instant_on():
    log = FlightSimulation(SHORT, Replacements({"mpc": corrupted("u", np.nan, after_s=0.0)})).fly()
    assert "mpc::corruption: corrupted not finite at -0.10 s" in log.exit_cause
    assert log.time_s.tolist() == [-0.1]


def test_values_that_are_too_large_for_the_plant():
    force = corrupted("generalized_force", np.inf, after_s=0.35)
    log = FlightSimulation(SHORT, Replacements({"wind": force})).fly()
    assert (
        log.exit_reason == "lost"
        and "station::physics::wind::corruption: corrupted" in log.exit_cause
    )


@pytest.mark.parametrize("error", [BadInput("/tmp", "", "full"), OSError("full"), MemoryError()])
def test_errors_of_the_machine_are_raised_even_if_a_port_is_not_finite(error):
    """Here the samples, by a fault."""

    def progress(time_s: float) -> None:
        if time_s > 0.25:
            raise error

    faulty = replace(SHORT, faults=(SampleNan(start_s=0.05),))
    with pytest.raises(type(error)):
        FlightSimulation(faulty).fly(progress)


@pytest.mark.parametrize("name", ["clover", "moving_target"])
def test_packaged_scenarios_have_finite_signals(name):
    """Except d_g, which is infinite for a moving target."""
    scenario = load_scenario(name)
    closed_loop = make_closed_loop(scenario)
    assert not_finite(closed_loop, make_context(closed_loop, scenario.seed)) == []

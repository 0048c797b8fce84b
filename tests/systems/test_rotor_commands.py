"""Levels and dead time of the rotors' commands."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from aerodrake.scenario import Actuation, Rotor
from aerodrake.systems.rotor_commands import make_rotor_dead_time, make_rotor_levels

TRIM = np.array([9.0, 10.0, 8.0, 9.5])
PERIOD = 0.001


def test_silent_ones_are_no_systems():
    assert make_rotor_levels(Actuation(), Rotor(), 4) is None
    assert make_rotor_dead_time(Actuation(), TRIM, PERIOD) is None


@pytest.mark.parametrize("count", [7, 1000])
def test_a_ramp_is_rounded_to_the_nearest_level(count):
    levels = make_rotor_levels(Actuation(rotor_levels=count), Rotor(max_thrust_n=20.0), 1)
    context, step = levels.CreateDefaultContext(), 20.0 / count
    commands, rounded = np.linspace(0, 20, 501), []
    for command in commands:
        levels.get_input_port().FixValue(context, [command])
        rounded.append(levels.get_output_port().Eval(context)[0])
    assert np.abs(rounded - commands).max() <= step / 2 + 1e-12
    np.testing.assert_allclose(rounded, step * np.round(np.array(rounded) / step), atol=1e-12)
    assert len(np.unique(np.round(rounded, 9))) == min(count + 1, 501)


@pytest.mark.parametrize("steps", [1, 5, 40])
def test_a_step_of_the_command_arrives_after_the_dead_time(steps):
    """Read at each step of the plant, as the rotors do: before the step's own update."""
    config = Actuation(rotor_dead_time_s=steps * PERIOD)
    builder = DiagramBuilder()
    delay = builder.AddNamedSystem("delay", make_rotor_dead_time(config, TRIM, PERIOD))
    builder.ExportInput(delay.get_input_port(), "u0")
    log = LogVectorOutput(delay.get_output_port(), builder, PERIOD)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context, changed_at = simulator.get_mutable_context(), 0.0105
    diagram.get_input_port().FixValue(context, TRIM)
    simulator.AdvanceTo(changed_at)
    diagram.get_input_port().FixValue(context, TRIM + 1)
    simulator.AdvanceTo(0.06)
    found = log.FindLog(context)
    is_new = found.sample_times() > changed_at + steps * PERIOD
    np.testing.assert_allclose(found.data()[:, ~is_new], TRIM[:, None] + np.zeros(sum(~is_new)))
    np.testing.assert_allclose(found.data()[:, is_new], TRIM[:, None] + np.ones(sum(is_new)))

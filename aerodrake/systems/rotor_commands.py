"""Levels and dead time of the rotors' commands, as systems of Drake's own."""

import numpy as np
from pydrake.symbolic import Variable, floor
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.scenario import Actuation, Rotor
from aerodrake.support.arguments import Count, Period, Vector, checked
from aerodrake.systems.delay import make_delay


@checked
def make_rotor_levels(
    config: Actuation, rotor: Rotor, rotors: Count
) -> SymbolicVectorSystem | None:
    """Makes the system that rounds commands to levels, with k = `rotors`; None without levels.

    Ports:
        in `u0` (k): N, commanded thrusts.
        out `y0` (k): N, the nearest multiples of the largest thrust over the number of levels.
    """
    if config.rotor_levels == 0:
        return None
    step = rotor.max_thrust_n / config.rotor_levels
    command = [Variable(f"c{i}") for i in range(rotors)]
    output = [step * floor(c / step + 0.5) for c in command]
    return SymbolicVectorSystem(input=np.array(command), output=np.array(output))


@checked
def make_rotor_dead_time(config: Actuation, trim: Vector, period: Period) -> Diagram | None:
    """Makes the diagram that delays commands; None without dead time.

    Ports:
        in `u0` (k): N, commanded thrusts.
        out `y0` (k): N, the commands of the dead time before; those of trim at first.

    Args:
        config: The dead time, a multiple of `period`.
        trim: (k,) N, thrusts in trim.
        period: s, the plant's step.
    """
    steps = round(config.rotor_dead_time_s / period)
    if steps == 0:
        return None
    builder = DiagramBuilder()
    deviation, delay, late = make_delay(trim, steps, period)
    builder.AddNamedSystem("command_deviation", deviation)
    builder.AddNamedSystem("command_delay", delay)
    builder.AddNamedSystem("late_command", late)
    builder.Connect(deviation.get_output_port(), delay.get_input_port())
    builder.Connect(delay.get_output_port(), late.get_input_port())
    builder.ExportInput(deviation.get_input_port(), "u0")
    builder.ExportOutput(late.get_output_port(), "y0")
    return builder.Build()

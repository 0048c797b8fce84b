"""Where numbers that are not finite come from."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, Diagram, InputPort, OutputPort, PortDataType, System

from aerodrake.wiring.diagrams import leaf_systems

MAY_BE_INFINITE = frozenset({"d_g"})
"""Signals of which infinity says something: a moving target is never passed twice."""


def not_finite(diagram: Diagram, context: Context) -> list[str]:
    """The output ports whose numbers are not finite although all inputs of their systems are.

    Each as `path of the system: port`, without what cannot be evaluated.

    Args:
        diagram: With ports that are vectors; others are not looked at.
        context: Of the diagram, at the instant that is looked at.
    """
    found = []
    for system in leaf_systems(diagram):
        own = system.GetMyContextFromRoot(context)
        inputs = map(system.get_input_port, range(system.num_input_ports()))
        if all(_is_sound(port, own) for port in inputs):
            outputs = map(system.get_output_port, range(system.num_output_ports()))
            spoilt = [port.get_name() for port in outputs if not _is_sound(port, own)]
            found += [f"{_path(system)}: {name}" for name in spoilt]
    return found


def _is_sound(port: InputPort | OutputPort, context: Context) -> bool:
    if port.get_data_type() != PortDataType.kVectorValued or port.get_name() in MAY_BE_INFINITE:
        return True
    try:
        return bool(np.isfinite(port.Eval(context)).all())
    except (Exception, SystemExit):  # Unconnected, or of what needs finite numbers itself.
        return True


def _path(system: System) -> str:
    """From the diagram down, such as `station::flight_controller`."""
    return system.GetSystemPathname().removeprefix("::").partition("::")[2]

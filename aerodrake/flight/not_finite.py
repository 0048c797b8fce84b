"""Search for the systems that output NaN or infinite values first."""

import numpy as np
from pydrake.systems.framework import Context, Diagram, InputPort, OutputPort, PortDataType, System

from aerodrake.station import leaf_systems

MAY_BE_INFINITE = frozenset({"d_g"})
"""Signals with a meaning for infinity: a moving target has an infinite diameter."""


def not_finite(diagram: Diagram, context: Context) -> list[str]:
    """Returns the output ports with NaN or infinity whose systems have only finite inputs.

    Each is `path of the system: port`. Ports that cannot be evaluated, and abstract ones, are
    left out.

    Args:
        diagram: The diagram.
        context: Context of the diagram, at the time of interest.
    """
    ports = []
    for system in leaf_systems(diagram):
        own = system.GetMyContextFromRoot(context)
        inputs = map(system.get_input_port, range(system.num_input_ports()))
        if all(_is_finite(port, own) for port in inputs):
            outputs = map(system.get_output_port, range(system.num_output_ports()))
            names = [port.get_name() for port in outputs if not _is_finite(port, own)]
            ports += [f"{_path(system)}: {name}" for name in names]
    return ports


def _is_finite(port: InputPort | OutputPort, context: Context) -> bool:
    if port.get_data_type() != PortDataType.kVectorValued or port.get_name() in MAY_BE_INFINITE:
        return True
    try:
        return bool(np.isfinite(port.Eval(context)).all())
    except (Exception, SystemExit):  # Not connected, or its computation needs finite inputs.
        return True


def _path(system: System) -> str:
    """Returns the path below the diagram, such as `station::flight_controller`."""
    return system.GetSystemPathname().removeprefix("::").partition("::")[2]

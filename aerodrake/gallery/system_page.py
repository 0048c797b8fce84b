"""A page of documentation for one system or diagram, made from its code.

Ports, state and rate are those of the system itself; their meaning is from its docstring, and
the equations are those that its module imports.
"""

import inspect
import sys
from collections.abc import Callable, Collection, Iterator

from pydrake.systems.framework import Diagram, DiscreteStateIndex, InputPort, OutputPort, System

from aerodrake.coordinator import make_coordinator
from aerodrake.gallery.docstring import Docstring
from aerodrake.gallery.drake_systems import BY_NAME, description, port_description
from aerodrake.gallery.graph import all_systems, graph_of, label
from aerodrake.gallery.mermaid import to_mermaid
from aerodrake.gallery.ports import Port, input_ports, opens, output_ports, size
from aerodrake.station import leaf_systems, make_closed_loop, make_station
from aerodrake.systems.named_state import NamedState
from aerodrake.wire.remote_coordinator import make_remote_coordinator
from aerodrake.wiring.guidance import make_guidance
from aerodrake.wiring.physics import make_physics
from aerodrake.wiring.plant import make_plant
from aerodrake.wiring.sensors import make_sensors
from aerodrake.wiring.wind import make_wind

MAKERS: dict[str, Callable[..., Diagram]] = {
    "closed_loop": make_closed_loop,
    "station": make_station,
    "coordinator": make_coordinator,
    "remote_coordinator": make_remote_coordinator,
    "guidance": make_guidance,
    "physics": make_physics,
    "plant": make_plant,
    "wind": make_wind,
    "sensors": make_sensors,
}
"""Function that makes each diagram, by its name; its docstring describes the diagram."""

EQUATIONS = "aerodrake.model."


def system_page(name: str, system: System, depth: int, pages: Collection[str] = ()) -> str:
    """Returns Markdown with the title `name`: kind, graphs, ports, state, rate and equations.

    Args:
        name: Title, and stem of the names of its files.
        system: Diagram or leaf system.
        depth: As for `graph_of`.
        pages: Names with a page in the same folder, for links.
    """
    maker = MAKERS.get(name) if isinstance(system, Diagram) else None
    docstring = Docstring.of(maker or (type(system) if _is_ours(system) else None))
    if not maker and not _is_ours(system):
        docstring = description(system)
    blocks = [
        f"# {name}",
        f"*{_kind(system, maker)}*",
        docstring.text,
        f"![N-squared chart of {name}]({name}_n2.svg)" if opens(system, depth) else "",
        f"```mermaid\n{to_mermaid(system, depth).rstrip()}\n```",
        *_ports("Inputs", system),
        *_ports("Outputs", system),
        *_state(system, docstring),
        *_rate(system, docstring),
        *_parts(system, pages),
        *_connections(system),
        *_wiring(maker),
        *_equations(system),
    ]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _kind(system: System, maker: Callable[..., Diagram] | None) -> str:
    if maker is not None:
        return f"A diagram of {_place(maker)}."
    if _is_ours(system):
        return f"A LeafSystem of {_place(type(system))}."
    kind, function = type(system), BY_NAME.get(system.get_name())
    made = f", made by {_place(function)}" if inspect.isfunction(function) else ""
    return f"{kind.__name__} of {kind.__module__}{made}: see Drake's documentation."


def _place(thing: type | Callable[..., object]) -> str:
    return f"`{thing.__name__}` in `{thing.__module__.replace('.', '/')}.py`"


def _is_ours(system: System) -> bool:
    """Returns True if the system is written in Python, and not one of Drake's."""
    return not type(system).__module__.startswith("pydrake")


def _ports(title: str, system: System) -> Iterator[str]:
    is_input = title == "Inputs"
    ports = input_ports(system) if is_input else output_ports(system)
    if not ports:
        return
    yield f"## {title}"
    rows = []
    for port in ports:
        ends = _ends(port)
        # The first docstring that explains a shared signal.
        meaning = next(filter(None, (_meaning(end) for end in ends)), "")
        at = "" if ends == [port] else ", ".join(f"`{e.get_system().get_name()}`" for e in ends)
        rows.append((f"`{port.get_name()}`", size(port), _feeds(port), at, meaning))
    of = "to" if is_input else "of"
    yield _table(("port", "size", "feeds through from", of, "meaning"), rows)


def _feeds(port: Port) -> str:
    """Returns the inputs with direct feedthrough to an output."""
    if isinstance(port, InputPort):
        return ""
    system = port.get_system()
    return ", ".join(
        f"`{given.get_name()}`"
        for given in input_ports(system)
        if system.HasDirectFeedthrough(given.get_index(), port.get_index())
    )


def _ends(port: Port) -> list[Port]:
    """Returns the ports of leaf systems that a port of a diagram exports; of a leaf, itself."""
    system = port.get_system()
    if not isinstance(system, Diagram):
        return [port]
    if isinstance(port, OutputPort):
        inner, index = system.get_output_port_locator(port.get_index())
        return _ends(inner.get_output_port(index))
    order = system.GetSystems().index  # Drake orders them by address.
    locators = system.GetInputPortLocators(port.get_index())
    locators = sorted(locators, key=lambda locator: (order(locator[0]), locator[1]))
    return [end for inner, index in locators for end in _ends(inner.get_input_port(index))]


def _meaning(port: Port) -> str:
    """Returns the meaning of a port from the docstring of its system's class or a base class."""
    key = ("in" if isinstance(port, InputPort) else "out", port.get_name())
    if not _is_ours(port.get_system()):
        return port_description(port.get_system(), *key)
    for kind in type(port.get_system()).__mro__:
        if "Ports" in (docstring := Docstring.of(kind)).sections and key in docstring.ports:
            return docstring.ports[key]
    return ""


def _state(system: System, docstring: Docstring) -> Iterator[str]:
    if isinstance(system, Diagram):
        return  # Its parts have pages of their own.
    context, names = system.CreateDefaultContext(), _group_names(system)
    groups = [
        (f"`{names.get(i, 'x')}`", str(context.get_discrete_state(i).size()))
        for i in range(context.num_discrete_state_groups())
    ]
    text = docstring.sections.get("State", docstring.sections.get("State, rate", ""))
    if groups or text:
        yield "## State"
        yield text
        if groups:
            yield _table(("discrete group", "size"), groups)
        if context.num_abstract_states():
            yield f"Abstract states: {context.num_abstract_states()}."


def _group_names(system: System) -> dict[int, str]:
    """Returns the names of discrete groups by index, from the attributes of the system.

    They are the fields of a `NamedState`, with a prefix if there is a NamedTuple of several, the
    keys of a dictionary of groups, or the name of the attribute with a single group.
    """
    names: dict[int, str] = {}
    for attribute, value in getattr(system, "__dict__", {}).items():
        name = attribute.lstrip("_").removeprefix("x_")
        parts = value._asdict() if hasattr(value, "_asdict") else {"": value}
        for prefix, part in parts.items():
            groups = part.groups if isinstance(part, NamedState) else part
            for group, index in (groups if isinstance(groups, dict) else {name: groups}).items():
                if isinstance(index, DiscreteStateIndex):
                    names[int(index)] = f"{prefix}.{group}".lstrip(".")
    return names


def _rate(system: System, docstring: Docstring) -> Iterator[str]:
    if isinstance(system, Diagram):
        rows = [
            (f"`{label(part)}`", *_period(part))
            for part in leaf_systems(system)
            if any(_period(part))
        ]
        if rows:
            yield "## Rates"
            yield "Discrete updates. Other systems have none, or unrestricted ones."
            yield _table(("system", "every", "after"), rows)
        return
    period, offset = _period(system)
    text = docstring.sections.get("Rate", "")
    if period or text:
        yield "## Rate"
        yield text
        if period:
            yield f"A discrete update every {period}" + f", after {offset}" * bool(offset) + "."


def _period(system: System) -> tuple[str, str]:
    """Returns period and offset of a system's discrete update; empty if it has none."""
    attribute = system.GetUniquePeriodicDiscreteUpdateAttribute()
    if attribute is None:
        return "", ""
    offset = attribute.offset_sec()
    return f"{1e3 * attribute.period_sec():g} ms", f"{1e3 * offset:g} ms" if offset else ""


def _parts(system: System, pages: Collection[str]) -> Iterator[str]:
    """Yields the names of the systems in a diagram, those of diagrams before those in them."""
    if isinstance(system, Diagram):
        yield "## Parts"
        names = [label(inner) for inner in all_systems(system)][1:]
        yield ", ".join(f"[{name}]({name}.md)" if name in pages else f"`{name}`" for name in names)


def _connections(system: System) -> Iterator[str]:
    """Yields the connections between the systems of a diagram, in signal order."""
    if not isinstance(system, Diagram):
        return
    order = [box.label for box in graph_of(system, 1).boxes]
    rows = [
        (label(source), source.get_output_port(o).get_name())
        + (label(target), target.get_input_port(i).get_name())
        for (target, i), (source, o) in system.connection_map().items()
    ]
    rows.sort(key=lambda row: (order.index(row[0]), order.index(row[2]), row[1], row[3]))
    if rows:
        yield "## Connections"
        titles = ("from", "output", "to", "input")
        yield _table(titles, [tuple(f"`{name}`" for name in row) for row in rows])


def _wiring(maker: Callable[..., Diagram] | None) -> Iterator[str]:
    """Yields the docstring of the module that wires a diagram, and its table of rates."""
    if maker is None:
        return
    module = sys.modules[maker.__module__]
    yield "## Wiring"
    yield f"```text\n{inspect.getdoc(module)}\n```"
    if rates := getattr(module, "RATES", ()):
        rows = [
            (", ".join(f"`{name}`" for name in rate.systems), f"`{rate.period}`")
            + (f"{rate.offset_steps:g}" if rate.offset_steps else "", rate.kind)
            for rate in rates
        ]
        yield _table(("systems", "period", "offset / plant steps", "kind"), rows)


def _equations(system: System) -> Iterator[str]:
    """Yields the functions and classes of the model that the system's module imports.

    Classes are followed by their base classes.
    """
    if isinstance(system, Diagram) or not _is_ours(system):
        return
    equations = []
    for thing in vars(sys.modules[type(system).__module__]).values():
        thing = getattr(thing, "py_func", thing)  # Of a compiled function.
        is_function = inspect.isfunction(thing)
        for part in (thing,) if is_function else getattr(thing, "__mro__", ()):
            if part.__module__.startswith(EQUATIONS) and inspect.getdoc(part):
                equations.append(f"### {_place(part)}\n\n```text\n{inspect.getdoc(part)}\n```")
    if equations:
        yield "## Equations"
        yield from equations


def _table(titles: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Returns rows as a Markdown table, without empty columns."""
    used = [i for i in range(len(titles)) if any(row[i] for row in rows)]
    lines = [[titles[i] for i in used], ["---"] * len(used)]
    lines += [[row[i].replace("|", "\\|") for i in used] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)

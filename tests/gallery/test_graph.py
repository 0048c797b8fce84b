"""Drawings: complete, deterministic, and in the order of the signals."""

import pytest
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain, Integrator

from aerodrake.gallery.dot import to_dot
from aerodrake.gallery.graph import graph_of, systems_by_name
from aerodrake.gallery.mermaid import to_mermaid
from aerodrake.gallery.n2_chart import n2_svg
from aerodrake.scenario import Scenario
from aerodrake.station import STATION_INTERFACE, make_closed_loop

DEPTH = 2


@pytest.fixture(scope="module")
def closed_loop():
    return make_closed_loop(Scenario())


@pytest.fixture(scope="module")
def systems(closed_loop):
    return systems_by_name(closed_loop)


def make_small(names=("two", "sum")):
    """`two` drives both inputs of `sum`, beside an exported input."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem(names[0], ConstantVectorSource([2.0]))
    adder = builder.AddNamedSystem(names[1], Adder(3, 1))
    for i in range(2):
        builder.Connect(source.get_output_port(), adder.get_input_port(i))
    builder.ExportInput(adder.get_input_port(2), "offset")
    builder.ExportOutput(adder.get_output_port(), "total")
    diagram = builder.Build()
    diagram.set_name("small")
    return diagram


def labels(graph):
    return [box.label for box in graph.leaves]


def arrows(graph):
    """{(source, target): signals}."""
    return {(a.source.label, a.target.label): a.signals for a in graph.arrows}


def inside(boxes, name):
    (box,) = (box for box in boxes if box.label == name)
    return [leaf.label for leaf in box.leaves]


def test_every_system_has_its_name(closed_loop, systems):
    sides = [closed_loop.GetSubsystemByName(name) for name in ("station", "coordinator")]
    inner = [system.get_name() for side in sides for system in side.GetSystems()]
    in_physics = ["plant", "rotors", "wind", "forces"]
    in_plant = ["multibody_plant", "scene_graph", "propellers"]
    in_wind = ["gust_noise", "air", "wind_force"]
    in_sensors = ["sensor_noise", "sampler", "state_filter"]
    in_guidance = ["reference", "reference_guard"]
    opened = {
        *("closed_loop", "station", "coordinator"), *inner, *in_physics, *in_plant, *in_wind,
        *in_sensors, *in_guidance,
    }  # fmt: skip
    assert set(systems) == opened
    assert {"physics", "mpc", "sensors", "pushes"} <= set(inner)
    assert systems["closed_loop"] is closed_loop


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (("same", "small"), "two named 'small'"),
        (("", "sum"), "ConstantVectorSource@"),
    ],
)
def test_shared_and_missing_names_are_refused(names, problem):
    with pytest.raises(ValueError, match=problem):
        systems_by_name(make_small(names))


@pytest.mark.parametrize("draw", [to_dot, to_mermaid, n2_svg])
def test_two_builds_give_the_same_bytes(systems, draw):
    again = systems_by_name(make_closed_loop(Scenario()))
    for name, system in systems.items():
        assert draw(system, DEPTH) == draw(again[name], DEPTH), name


def test_signal_order(closed_loop):
    graph = graph_of(closed_loop, DEPTH)
    assert inside(graph.boxes, "station") == [
        *("pushes", "flight_controller", "arm_controller", "physics", "sensors", "rotor_monitor"),
    ]
    assert inside(graph.boxes, "coordinator") == [
        *("guidance", "kinematics", "weight_allocator", "equivalent_state", "residual_estimator"),
        *("mpc", "supervisor", "setpoint_integrator"),
    ]
    back = {(a.source.label, a.target.label) for a in graph.arrows if a.is_feedback}
    setpoints = ["flight_controller", "arm_controller", "sensors"]
    models = ["equivalent_state", "residual_estimator", "mpc"]
    assert back == {
        *(("setpoint_integrator", target) for target in setpoints + models),
        *(("sensors", target) for target in ("flight_controller", "arm_controller")),
    }


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_rows_follow_the_signals(systems, depth):
    """Forward arrows lead downwards, no arrow within a row, and the station is above."""
    for system in systems.values():
        graph = graph_of(system, depth)
        place = {box.id: i for i, box in enumerate(graph.leaves)}
        assert len(place) == len(graph.leaves)
        for arrow in graph.arrows:
            is_back = place[arrow.target.id] < place[arrow.source.id]
            assert arrow.is_feedback == is_back
            assert arrow.source.rank != arrow.target.rank
    if depth > 1:
        station, coordinator = graph_of(systems["closed_loop"], depth).boxes
        lowest = max(leaf.rank for leaf in station.leaves)
        assert lowest < min(leaf.rank for leaf in coordinator.leaves)


@pytest.mark.parametrize("name", ["station", "coordinator"])
def test_every_connection_is_drawn(systems, name):
    diagram = systems[name]
    for whole, depth in ((diagram, 1), (systems["closed_loop"], DEPTH)):
        drawn = arrows(graph_of(whole, depth))
        for (target, i), (source, o) in diagram.connection_map().items():
            ports = source.get_output_port(o), target.get_input_port(i)
            assert {port.get_name() for port in ports} & set(
                drawn[source.get_name(), target.get_name()]
            )


def test_signals_are_followed_into_and_out_of_diagrams(closed_loop):
    drawn = arrows(graph_of(closed_loop, DEPTH))
    for consumer in ("kinematics", "mpc", "residual_estimator", "flight_controller"):
        assert "state" in drawn["sensors", consumer]
    assert drawn["setpoint_integrator", "arm_controller"] == ("joint_setpoint",)
    for consumer in ("flight_controller", "equivalent_state", "mpc"):
        assert drawn["setpoint_integrator", consumer] == ("base_setpoint", "joint_setpoint")
    opened = arrows(graph_of(closed_loop, DEPTH + 1))
    assert drawn["arm_controller", "physics"] == opened["arm_controller", "plant"]
    assert drawn["physics", "sensors"] == ("true_state",)
    assert opened["plant", "wind"] == opened["plant", "sampler"] == ("state",)


def test_depth(closed_loop, systems):
    closed = [box.label for box in graph_of(closed_loop, 0).leaves if box.system is not None]
    assert closed == ["closed_loop"]
    shallow = graph_of(closed_loop, 1)
    assert labels(shallow) == ["station", "coordinator"]
    assert arrows(shallow) == {
        ("station", "coordinator"): tuple(sorted(STATION_INTERFACE)),
        ("coordinator", "station"): ("base_setpoint", "joint_setpoint"),
    }
    leaves = {name for name, system in systems.items() if not isinstance(system, Diagram)}
    assert set(labels(graph_of(closed_loop, DEPTH + 2))) == leaves
    assert graph_of(closed_loop, 9) == graph_of(closed_loop, DEPTH + 2)


def test_some_systems_are_left_out(closed_loop):
    graph = graph_of(closed_loop, DEPTH, without=["coordinator"])
    assert [box.label for box in graph.boxes] == ["station"]
    assert all({a.source, a.target} <= set(graph.leaves) for a in graph.arrows)


def test_ports_of_the_drawn_system(systems):
    graph = graph_of(systems["mpc"], DEPTH)
    ports = [box.label for box in graph.leaves if box.system is None]
    assert "end_effector (abstract)" in ports and "u (9)" in ports
    assert len(ports) == systems["mpc"].num_input_ports() + systems["mpc"].num_output_ports()
    assert not any(
        "WorldModelInstance" in box.label for box in graph_of(systems["multibody_plant"], 0).boxes
    )
    drawn = arrows(graph_of(systems["coordinator"], 1))
    assert drawn["inputs", "mpc"] == ("state",)
    assert drawn["mpc", "outputs"] == ("delta", "plan", "prediction", "status", "u", "weights")
    assert "outputs" not in labels(graph_of(systems["closed_loop"], 1)), "it has no inputs"


def test_names_and_labels_of_a_users_own_diagram():
    """Unnamed systems, a loop of a system with itself, and names that only their diagram has."""
    builder = DiagramBuilder()
    integrator = builder.AddSystem(Integrator(1))
    builder.Connect(integrator.get_output_port(), integrator.get_input_port())
    parts = [builder.AddNamedSystem(name, make_small()) for name in ("left", "end")]
    for part in parts:
        builder.Connect(integrator.get_output_port(), part.get_input_port())
    builder.AddNamedSystem("end of it", Gain(1.0, 1))
    graph = graph_of(builder.Build(), 2)
    assert inside(graph.boxes, "left") == inside(graph.boxes, "end") == ["two", "sum"]
    assert {"Integrator", "end of it"} <= set(labels(graph))
    ids = [box.id for box in graph.leaves]
    assert len(set(ids)) == len(ids) and "end_of_it" in ids and "two_2" in ids
    assert ("Integrator", "Integrator") in arrows(graph)

"""Graphs: deterministic and complete."""

import re

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain

from aerodrake.gallery.graph import systems_by_name, to_dot, to_mermaid
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


def nodes(mermaid):
    return set(re.findall(r"^ +(?:subgraph )?(\w+)$", mermaid, re.MULTILINE)) - {"end"}


def arrows(mermaid):
    """{(source, target): label}."""
    matches = re.findall(r'^  (\w+) -->(?:\|"(.*)"\|)? (\w+)$', mermaid, re.MULTILINE)
    return {(source, target): label for source, label, target in matches}


def exported(mermaid):
    return set(re.findall(r"^  (\w+)\(\[", mermaid, re.MULTILINE))


def test_every_system_has_its_name(closed_loop, systems):
    sides = [closed_loop.GetSubsystemByName(name) for name in ("station", "coordinator")]
    inner = [system.get_name() for side in sides for system in side.GetSystems()]
    in_wind = ["gust_noise", "air", "wind_force"]
    in_sensors = ["sensor_noise", "sampler", "state_filter"]
    in_guidance = ["reference", "reference_guard"]
    opened = {
        "closed_loop", "station", "coordinator", *inner, *in_wind, *in_sensors, *in_guidance
    }  # fmt: skip
    assert set(systems) == opened
    assert {"plant", "mpc", "sensors", "wind"} <= set(inner)
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


def test_two_builds_give_the_same_bytes(systems):
    again = systems_by_name(make_closed_loop(Scenario()))
    for name, system in systems.items():
        assert to_dot(system, DEPTH) == to_dot(again[name], DEPTH), name
        assert to_mermaid(system, DEPTH) == to_mermaid(again[name], DEPTH), name


def test_dot_renumbers_ids_and_nothing_else():
    builder = DiagramBuilder()
    builder.AddNamedSystem("s7", Gain(1.0, 1))
    diagram = builder.Build()
    diagram.set_name("cluster7diagram")
    text = to_dot(diagram, 1)
    assert "name=s7\n" in text and "name=cluster7diagram\n" in text
    assert text.startswith("digraph _1 {") and "\ns2 [" in text


@pytest.mark.parametrize("depth", [0, 1, 2])
def test_dot_is_valid(systems, depth):
    for name, system in systems.items():
        text = to_dot(system, depth)
        ports, node = set(), ""
        for line in text.splitlines():
            if declared := re.match(r"(s\d+(?:in|out)?) \[", line):
                node = declared[1]
            ports |= {(node, port) for port in re.findall(r'PORT="(\w+)"', line)}
        ends = re.findall(r"(s\d+(?:in|out)?):(\w+):[ew]", text)
        assert len(ends) == 2 * text.count(" -> ")
        assert set(ends) <= ports, name
        assert text.count("{") == text.count("}")
        assert not re.search(r"0x|[0-9a-f]{12}", text), "an address"


def test_mermaid_draws_every_system(closed_loop, systems):
    assert nodes(to_mermaid(closed_loop, DEPTH + 1)) == set(systems) - {"closed_loop"}


@pytest.mark.parametrize("name", ["station", "coordinator"])
def test_mermaid_draws_every_connection(systems, name):
    diagram = systems[name]
    for inside, depth in ((diagram, 1), (systems["closed_loop"], DEPTH)):
        drawn = arrows(to_mermaid(inside, depth))
        for (target, i), (source, o) in diagram.connection_map().items():
            label = drawn[source.get_name(), target.get_name()]
            for port in (source.get_output_port(o), target.get_input_port(i)):
                default = re.fullmatch(r"[uy]\d+", port.get_name())
                assert default or port.get_name() in re.split(" → |<br/>", label)


def test_mermaid_follows_signals_into_and_out_of_diagrams(closed_loop):
    drawn = arrows(to_mermaid(closed_loop, DEPTH))
    for consumer in ("kinematics", "mpc", "residual_estimator", "flight_controller"):
        assert drawn["sensors", consumer] == "state"
    assert drawn["setpoint_integrator", "arm_controller"] == "joint_setpoint"
    for consumer in ("flight_controller", "equivalent_state", "mpc"):
        assert drawn["setpoint_integrator", consumer] == "base_setpoint<br/>joint_setpoint"
    assert drawn["plant", "sensors"] == "state → true_state"
    opened = arrows(to_mermaid(closed_loop, DEPTH + 1))
    assert (
        drawn["wind", "plant"]
        == opened["wind_force", "plant"]
        == ("generalized_force → applied_generalized_force")
    )
    assert drawn["plant", "wind"] == opened["plant", "wind_force"] == "state → true_state"


def test_mermaid_depth(closed_loop):
    assert nodes(to_mermaid(closed_loop, 0)) == {"closed_loop"}
    shallow = to_mermaid(closed_loop, 1)
    assert nodes(shallow) == {"station", "coordinator"}
    assert arrows(shallow) == {
        ("station", "coordinator"): "<br/>".join(sorted(STATION_INTERFACE)),
        ("coordinator", "station"): "base_setpoint<br/>joint_setpoint",
    }
    assert to_mermaid(closed_loop, 9) == to_mermaid(closed_loop, DEPTH + 1)


def test_mermaid_exported_ports(closed_loop, systems):
    assert not exported(to_mermaid(closed_loop, DEPTH)), "outputs of a closed loop are left out"
    for name in ("coordinator", "mpc", "reference"):
        system = systems[name]
        inputs = map(system.get_input_port, range(system.num_input_ports()))
        outputs = map(system.get_output_port, range(system.num_output_ports()))
        names = [f"in_{port.get_name()}" for port in inputs]
        names += [f"out_{port.get_name()}" for port in outputs]
        assert exported(to_mermaid(system, DEPTH)) == set(names)
    assert '(["end_effector (abstract)"])' in to_mermaid(systems["mpc"], 0)
    assert "WorldModelInstance" not in to_mermaid(systems["plant"], 0), "ports of size zero"


def test_mermaid_text():
    expected = """\
flowchart TB
  in_offset(["offset (1)"])
  two
  sum
  out_total(["total (1)"])
  in_offset --> sum
  two --> sum
  sum -->|"sum"| out_total
"""
    assert to_mermaid(make_small(), 1) == expected

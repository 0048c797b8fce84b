"""Wiring tables: connections, inserted systems, shared inputs and exports."""

import numpy as np
import pytest
from pydrake.symbolic import Variable
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, Gain, SymbolicVectorSystem

from aerodrake.wiring.table import Wiring, outputs, shared_input

WIRING = Wiring(
    connections=(("half", "y0", "sum", "u1"),),
    inputs=(("x", "half", "u0"), ("x", "sum", "u0")),
    outputs=(("half", "y0", "half"), ("sum", "sum", "total")),
)


def make_builder() -> DiagramBuilder:
    builder = DiagramBuilder()
    builder.AddNamedSystem("half", Gain(0.5, 2))
    builder.AddNamedSystem("sum", Adder(2, 2))
    return builder


def evaluate(diagram, port: str) -> np.ndarray:
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("x").FixValue(context, [2.0, 4.0])
    return diagram.GetOutputPort(port).Eval(context)


def test_one_input_feeds_several_systems():
    diagram = WIRING.build(make_builder(), "both")
    assert diagram.get_name() == "both" and diagram.num_input_ports() == 1
    np.testing.assert_array_equal(evaluate(diagram, "half"), [1.0, 2.0])
    np.testing.assert_array_equal(evaluate(diagram, "total"), [3.0, 6.0])


def test_an_inserted_system_feeds_targets_and_exports():
    builder, u = make_builder(), [Variable("u_0"), Variable("u_1")]
    negative = SymbolicVectorSystem(input=u, output=[-u[0], -u[1]])
    builder.AddNamedSystem("negative", negative)
    diagram = WIRING.insert("negative", ("half", "y0")).build(builder, "both")
    np.testing.assert_array_equal(evaluate(diagram, "half"), [-1.0, -2.0])
    np.testing.assert_array_equal(evaluate(diagram, "total"), [1.0, 2.0])


def test_a_system_inserted_before_a_port_takes_its_source_or_input():
    builder = make_builder()
    builder.AddNamedSystem("double", Gain(2.0, 2))
    builder.AddNamedSystem("triple", Gain(3.0, 2))
    wiring = WIRING.insert_before("double", ("sum", "u1")).insert_before("triple", ("half", "u0"))
    diagram = wiring.build(builder, "both")
    np.testing.assert_array_equal(evaluate(diagram, "half"), [3.0, 6.0])
    np.testing.assert_array_equal(evaluate(diagram, "total"), [8.0, 16.0])


def test_rename_and_sum():
    wiring = Wiring(outputs=outputs("mpc", "u", "plan")) + Wiring(
        inputs=shared_input("x", "a", "mpc")
    )
    renamed = wiring.rename("mpc", "clik")
    assert renamed.outputs == (("clik", "u", "u"), ("clik", "plan", "plan"))
    assert renamed.inputs == (("x", "a", "x"), ("x", "clik", "x"))


def test_an_unknown_system_is_refused():
    with pytest.raises(RuntimeError, match="third"):
        Wiring((("third", "y0", "sum", "u0"),)).build(make_builder(), "both")

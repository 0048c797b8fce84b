"""Tests of the reference as a system: ports, time, and outputs that follow the time."""

import math

import numpy as np
import pytest

from aerodrake.model.reference.curves import make_reference
from aerodrake.scenario import Clover, Hover, MovingTarget
from aerodrake.systems.reference import ReferenceSystem

START = np.array([0.0, 0.2, 1.2])
SETTLE_S, STAGES_S = 3.0, np.array([0.0, 0.02, 0.04, 0.1, 0.24])


def make_system(config=None):
    curve = make_reference(config or Clover(), START)
    return curve, ReferenceSystem(curve, START, SETTLE_S, STAGES_S)


def port(system, context, name):
    return system.GetOutputPort(name).Eval(context)


def test_ports_and_state():
    _, system = make_system()
    sizes = {
        system.get_output_port(i).get_name(): system.get_output_port(i).size()
        for i in range(system.num_output_ports())
    }
    assert sizes == {"reference": 6, "horizon": 6 * 5, "d_g": 1}
    assert system.num_input_ports() == 0
    assert system.CreateDefaultContext().is_stateless()
    assert not system.HasAnyDirectFeedthrough()


def test_outputs_are_the_curve_at_reference_time():
    curve, system = make_system()
    context = system.CreateDefaultContext()
    for t in (0.0, 2.9, 3.0, 4.5, 30.0, 1.0):  # One context: its cache must not go stale.
        context.SetTime(t)
        np.testing.assert_allclose(
            port(system, context, "reference"),
            np.concatenate(curve.evaluate(np.array([t - SETTLE_S])), axis=None),
        )
        horizon = port(system, context, "horizon").reshape(5, 6)
        for ahead, row in zip(STAGES_S, horizon, strict=True):
            # Before reference time 0 the horizon rests at the start.
            time = t - SETTLE_S + ahead if t >= SETTLE_S else 0.0
            p, v = curve.evaluate(np.array([time]))
            np.testing.assert_allclose(row, [*p[0], *v[0]], atol=1e-12)


def test_reference_rests_until_the_end_of_settling():
    _, system = make_system()
    context = system.CreateDefaultContext()
    for t in (0.0, 1.5, 3.0):
        context.SetTime(t)
        np.testing.assert_allclose(port(system, context, "reference"), [*START, 0, 0, 0])


@pytest.mark.parametrize(
    ("config", "diameter"), [(Hover(), 0.0), (Clover(), 1.0), (MovingTarget(), math.inf)]
)
def test_diameter(config, diameter):
    _, system = make_system(config)
    assert port(system, system.CreateDefaultContext(), "d_g") == [diameter]

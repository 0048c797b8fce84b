"""Setpoint link in the closed loop."""

from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator

from aerodrake.model.setpoint.integration import evaluate
from aerodrake.scenario import Actuation, Clover
from aerodrake.station import make_closed_loop, make_context
from aerodrake.wiring.setpoint_link import make_setpoint_link

LATENCY = 0.012


def test_there_is_no_link_without_flaws(scenario, vehicle):
    assert make_setpoint_link(scenario, vehicle) is None


def test_the_station_follows_the_setpoints_of_the_latency_before(scenario):
    link = Actuation(setpoint_latency_s=(LATENCY, LATENCY))
    flown = replace(scenario, settle_s=0.0, reference=Clover(start_s=0.2), actuation=link)
    loop = make_closed_loop(flown)
    context, station = make_context(loop, 0), loop.GetSubsystemByName("station")
    Simulator(loop, context).AdvanceTo(0.4155)
    inner = station.GetMyContextFromRoot(context)
    segment = loop.GetOutputPort("segment").Eval(context)  # Since 0.4 s.
    for name, first, end in (("base_setpoint", 0, 3), ("joint_setpoint", 3, 9)):
        received = station.GetInputPort(name).Eval(inner)
        np.testing.assert_allclose(received, evaluate(segment, 0.4155 - LATENCY, first, end))
        assert np.any(received != loop.GetOutputPort(name).Eval(context))

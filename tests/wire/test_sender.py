"""The sender publishes the station's signals periodically."""

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator

from aerodrake.wire.link import Link
from aerodrake.wire.message import Layout, Phase
from aerodrake.wire.sender import WireSender


def test_each_message_has_the_time_of_its_sample():
    lcm = DrakeLcm("memq://")
    layouts = (
        Layout({}, {"state": 2, "saturated": 1}),
        Layout({}, {"u": 1}),
    )
    link = Link(lcm, *layouts, is_station=True)
    sender = WireSender(link, 0.01, 0.00025)
    simulator = Simulator(sender)
    context = simulator.get_mutable_context()
    link.phase = Phase.FLYING
    sender.GetInputPort("saturated").FixValue(context, [1.0])
    sender.GetInputPort("state").FixValue(context, [1.0, 2.0])
    simulator.AdvanceTo(0.015)
    sender.GetInputPort("state").FixValue(context, [3.0, np.nan])
    simulator.AdvanceTo(0.03)
    coordinator = Link(lcm, *layouts, is_station=False)
    assert coordinator.receive() == []  # Earlier messages are lost.
    simulator.AdvanceTo(0.045)
    messages = coordinator.receive()
    assert [message.time for message in messages] == pytest.approx([0.03, 0.04], abs=1e-12)
    assert all(message.phase is Phase.FLYING for message in messages)
    np.testing.assert_array_equal(messages[0].signals["state"], [3.0, np.nan])
    assert messages[0].signals["saturated"].tolist() == [1.0]

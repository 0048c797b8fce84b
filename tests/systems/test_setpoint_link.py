"""Setpoint link against the coordinator's own setpoints."""

import numpy as np
import pytest
from pydrake.common import RandomDistribution
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import RandomSource

from aerodrake.model.actuation.setpoint_messages import LinkTiming
from aerodrake.model.setpoint.integration import Segment
from aerodrake.scenario import Actuation
from aerodrake.station import make_context
from aerodrake.systems.setpoint_link import SetpointLink

PERIOD, STEP, AXES = 0.02, 0.001, 5


class Coordinator(LeafSystem):
    """Segments whose positions are times and whose velocities are 1, from tick to tick."""

    def __init__(self):
        super().__init__()
        self._tick = self.DeclareDiscreteState(1)
        self.DeclareVectorOutputPort("segment", Segment.size(AXES), self._calc, {self.xd_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _update(self, context, discrete):
        discrete.set_value([context.get_time()])

    def _calc(self, context, output: BasicVector):
        tick = context.get_discrete_state(self._tick).value()[0]
        segment = Segment(np.full(AXES, tick), np.ones(AXES), np.zeros(AXES), tick)
        output.SetFromVector(segment.to_vector())


def delays(duration: float, seed: int = 0, **flaws) -> np.ndarray:
    """Returns the delay (T,) s of the setpoints at each step, half a step after the ticks."""
    timing = LinkTiming.make(Actuation(**flaws), PERIOD, ticks=5)
    builder = DiagramBuilder()
    coordinator = builder.AddNamedSystem("coordinator", Coordinator())
    noise = builder.AddNamedSystem("draws", RandomSource(RandomDistribution.kUniform, 2, PERIOD))
    link = builder.AddNamedSystem("link", SetpointLink(timing, np.zeros(AXES)))
    builder.Connect(coordinator.get_output_port(), link.GetInputPort("segment"))
    builder.Connect(noise.get_output_port(), link.GetInputPort("draws"))
    times = STEP / 2 + STEP * np.arange(round(duration / STEP))
    diagram = builder.Build()
    context = make_context(diagram, seed)
    simulator, found = Simulator(diagram, context), []
    for time in times:
        simulator.AdvanceTo(time)
        mine = link.GetMyContextFromRoot(context)
        base, joints = (
            link.GetOutputPort(name).Eval(mine) for name in ("base_setpoint", "joint_setpoint")
        )
        np.testing.assert_allclose(base[:3], joints[0], atol=1e-12)
        np.testing.assert_allclose([*base[3:6], *joints[2:4]], 1, atol=1e-12)
        found.append(time - base[0])
    return np.array(found)


def test_without_latency_the_setpoints_are_the_coordinators():
    np.testing.assert_allclose(delays(0.1, setpoint_loss=1e-9), 0, atol=1e-12)


@pytest.mark.parametrize("latency", [0.004, 0.020, 0.0335])
def test_a_constant_latency_delays_by_it(latency):
    found = delays(0.2, setpoint_latency_s=(latency, latency))
    started = STEP * np.arange(len(found)) > latency + PERIOD
    np.testing.assert_allclose(found[started], latency, atol=1e-12)


def test_the_first_message_arrives_at_once():
    found = delays(0.1, setpoint_latency_s=(0.03, 0.03))
    np.testing.assert_allclose(found[:20], 0, atol=1e-12)


def test_jitter_is_within_its_range_and_repeatable():
    flaws = {"setpoint_latency_s": (0.0, 0.02)}
    found = delays(2.0, **flaws)
    assert found.min() > -1e-12
    assert found.max() < 0.02
    assert len(np.unique(np.round(found, 9))) > 90  # About one for each message.
    np.testing.assert_array_equal(delays(0.5, **flaws), found[:500])
    assert not np.array_equal(delays(0.5, seed=1, **flaws), found[:500])


def test_losses_are_bridged_by_the_last_message():
    """The polynomial of the last message is correct here, whatever is lost."""
    np.testing.assert_allclose(delays(1.0, setpoint_loss=0.3), 0, atol=1e-12)

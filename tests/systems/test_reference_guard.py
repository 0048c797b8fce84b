"""Tests of the reference guard as a system, with reference faults before it."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.envelope import Envelope, ReferenceVerdict
from aerodrake.scenario import Lissajous, ReferenceJump, ReferenceNan, Supervisor
from aerodrake.systems.faults.reference import ReferenceFaultSystem
from aerodrake.systems.reference import ReferenceSystem
from aerodrake.systems.reference_guard import ReferenceGuard

DT, STAGES = 0.02, 4
START = np.array([0.0, 0.2, 1.2])
STAGES_S = DT * np.arange(STAGES + 1)
SETTLE_S = 0.1
CURVE = make_reference(Lissajous(), START)


def guard() -> ReferenceGuard:
    return ReferenceGuard(Envelope.make(Supervisor(), START), START, STAGES, DT)


class Follower:
    """Reference, faults and guard in a Simulator."""

    def __init__(self, *faults):
        builder = DiagramBuilder()
        reference = builder.AddSystem(ReferenceSystem(CURVE, START, SETTLE_S, STAGES_S))
        fault = builder.AddSystem(ReferenceFaultSystem(faults, SETTLE_S, STAGES_S))
        self.guard = builder.AddSystem(guard())
        builder.Connect(reference.GetOutputPort("horizon"), fault.GetInputPort("horizon"))
        builder.Connect(fault.GetOutputPort("horizon"), self.guard.GetInputPort("horizon"))
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.guard.GetMyContextFromRoot(self.simulator.get_context())

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray, ReferenceVerdict]:
        """Returns reference (6,), horizon (N + 1, 6) and verdict, 1 us after a time."""
        self.simulator.AdvanceTo(round(SETTLE_S + time, 9) + 1e-6)
        reference, horizon, verdict = (
            self.guard.GetOutputPort(port).Eval(self.context).copy()
            for port in ("reference", "horizon", "reference_verdict")
        )
        return reference, horizon.reshape(-1, 6), ReferenceVerdict(int(verdict[0]))


def requested(time: float) -> np.ndarray:
    """Returns the curve (6,) at the instant of `Follower.at`."""
    return np.hstack(CURVE.evaluate(np.array([round(time + 1e-6, 9)])))[0]


def test_without_faults_it_passes_the_reference_on():
    follower = Follower()
    for time in (-0.1, 0.0, 0.5, 1.3):
        reference, horizon, verdict = follower.at(time)
        np.testing.assert_allclose(reference, requested(time), atol=1e-7)
        np.testing.assert_array_equal(horizon[0], reference)
        assert verdict is ReferenceVerdict.OK


def test_rests_during_nan_and_then_follows_again():
    follower = Follower(ReferenceNan(start_s=1.0, duration_s=0.5))
    last, _, _ = follower.at(0.98)
    for time in (1.0, 1.2, 1.48):
        reference, horizon, verdict = follower.at(time)
        np.testing.assert_allclose(horizon[:, :3], np.tile(last[:3], (STAGES + 1, 1)), atol=1e-6)
        np.testing.assert_array_equal(horizon[:, 3:], 0)
        np.testing.assert_array_equal(reference, horizon[0])
        assert verdict is ReferenceVerdict.NOT_FINITE
    reference, _, verdict = follower.at(1.5)
    np.testing.assert_allclose(reference, requested(1.5), atol=1e-7)
    assert verdict is ReferenceVerdict.OK


def test_a_jump_is_followed_and_reported_at_both_its_ends():
    offset = np.array([0.3, 0.0, -0.2])
    follower = Follower(ReferenceJump(start_s=1.0, duration_s=0.5, offset_m=tuple(offset)))
    reported = []
    for k in range(40, 90):
        reference, _, verdict = follower.at(k * DT)
        is_on = 50 <= k < 75
        np.testing.assert_allclose(reference[:3], requested(k * DT)[:3] + offset * is_on, atol=1e-7)
        if verdict is not ReferenceVerdict.OK:
            reported.append((k, verdict))
    assert reported == [(50, ReferenceVerdict.JUMPED), (75, ReferenceVerdict.JUMPED)]


def test_between_ticks_it_follows_and_rests_as_at_ticks():
    """The log evaluates it at 100 Hz; a refused reference stays at that of the last good tick."""
    follower = Follower(ReferenceNan(start_s=1.0, duration_s=0.5))
    for time in (0.49, 0.5, 0.51, 0.99):
        reference, horizon, _ = follower.at(time)
        np.testing.assert_array_equal(reference, requested(time))
        np.testing.assert_array_equal(horizon[0], reference)
    last = np.hstack(CURVE.evaluate(np.array([0.98])))[0, :3]
    for time in (1.0, 1.01, 1.25, 1.49):
        reference, horizon, _ = follower.at(time)
        np.testing.assert_array_equal(reference, [*last, 0, 0, 0])
        np.testing.assert_array_equal(horizon, np.tile(reference, (STAGES + 1, 1)))


@pytest.mark.parametrize("port", ["horizon", "reference"])
def test_the_requested_reference_feeds_through(port):
    system = guard()
    assert system.HasDirectFeedthrough(0, system.GetOutputPort(port).get_index())


def test_the_verdict_does_not_feed_through_and_rate():
    system = guard()
    verdict = system.GetOutputPort("reference_verdict").get_index()
    assert not system.HasDirectFeedthrough(0, verdict)
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (DT, 0)

"""What the MPC is told of its faults, and when; and what it does then."""

import numpy as np
import pytest

from aerodrake.model.mpc.fault import MpcFault
from aerodrake.scenario import MpcInfeasible, MpcMissed, MpcNonFinite, MpcStarved, Push
from aerodrake.systems.faults.mpc import MpcFaultSystem

SETTLE_S = 3.0


def told(system: MpcFaultSystem, time: float) -> tuple[float, float]:
    context = system.CreateDefaultContext()
    context.SetTime(SETTLE_S + time)
    return tuple(system.GetOutputPort("fault").Eval(context))


def test_from_its_start_until_before_its_end():
    system = MpcFaultSystem([Push(), MpcMissed(start_s=0.1, duration_s=0.2)], SETTLE_S)
    for time, fault in ((0.0, 0), (0.1, 4), (0.29, 4), (0.3, 0), (1.0, 0)):
        assert told(system, time) == (fault, 0)


@pytest.mark.parametrize(
    ("kind", "fault"),
    [
        (MpcStarved(iterations=7), MpcFault.STARVED),
        (MpcInfeasible(), MpcFault.INFEASIBLE),
        (MpcNonFinite(), MpcFault.NON_FINITE),
        (MpcMissed(), MpcFault.MISSED),
    ],
)
def test_each_kind_has_its_code(kind, fault):
    expected = (fault, 7 if fault is MpcFault.STARVED else 0)
    assert told(MpcFaultSystem([kind], SETTLE_S), 5.5) == expected


def test_of_several_the_worst_counts_and_the_fewest_iterations():
    faults = [MpcStarved(iterations=9), MpcStarved(iterations=2), MpcInfeasible(duration_s=0.5)]
    system = MpcFaultSystem(faults, SETTLE_S)
    assert told(system, 5.2) == (MpcFault.INFEASIBLE, 2)
    assert told(system, 5.7) == (MpcFault.STARVED, 2)
    assert np.all(np.isfinite(told(system, 9.0)))

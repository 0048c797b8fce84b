"""Tests of the rotor monitor as a system: ports, rate, and the samples that it accepts."""

import numpy as np
import pytest

from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.supervision.rotor_monitor import RotorMonitor
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Rotor
from aerodrake.systems.rotor_monitor import RotorMonitorSystem

PERIOD = 0.01


@pytest.fixture
def trim(vehicle):
    return allocate(ThrustAllocation.make(vehicle, Rotor()), vehicle.trim_wrench)


@pytest.fixture
def system(vehicle, trim):
    return RotorMonitorSystem(RotorMonitor.make(vehicle, Rotor(), trim, 0.0, PERIOD), vehicle)


def test_ports_rate_and_feedthrough(system, vehicle):
    assert system.GetInputPort("sample").size() == VehicleState.size(vehicle.joints)
    assert system.GetInputPort("sample_health").size() == 6
    assert system.GetInputPort("thrust_command").size() == 4
    assert not system.HasAnyDirectFeedthrough()
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, 0)
    estimate = system.GetOutputPort("rotor_effectiveness").Eval(system.CreateDefaultContext())
    np.testing.assert_array_equal(estimate, np.ones(4))


def fall(system, vehicle, trim, samples: int, health=None, value=None) -> np.ndarray:
    """Returns the estimate (4,) for a base that rolls and falls as without its first rotor."""
    context = system.CreateDefaultContext()
    system.GetInputPort("thrust_command").FixValue(context, trim)
    if health is not None:
        system.GetInputPort("sample_health").FixValue(context, health)
    lost = trim[0] * np.array([-1.0, -vehicle.rotors.p_B[0, 1], vehicle.rotors.p_B[0, 0]])
    for k in range(samples):
        x = vehicle.trim_state
        at = 7 + vehicle.joints
        x[at : at + 2] = k * PERIOD * lost[1:] / np.diag(vehicle.inertia)[:2]
        x[at + 5] = k * PERIOD * lost[0] / vehicle.mass
        system.GetInputPort("sample").FixValue(
            context, x if value is None else np.full_like(x, value)
        )
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    return system.GetOutputPort("rotor_effectiveness").Eval(context)


def test_isolates_a_lost_rotor(system, vehicle, trim):
    estimate = fall(system, vehicle, trim, 12)
    assert estimate[0] < 0.4
    np.testing.assert_array_equal(estimate[1:], 1)


@pytest.mark.parametrize("group", range(3))
def test_rejected_samples_are_not_used(system, vehicle, trim, group):
    outage = np.eye(6)[group] * PERIOD
    np.testing.assert_array_equal(fall(system, vehicle, trim, 12, health=outage), 1)


def test_verdicts_alone_reject_no_sample(system, vehicle, trim):
    assert fall(system, vehicle, trim, 12, health=np.eye(6)[3:].sum(axis=0))[0] < 0.4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_samples_with_nan_or_infinite_are_not_used(system, vehicle, trim, value):
    np.testing.assert_array_equal(fall(system, vehicle, trim, 12, value=value), 1)

"""WindForce alone: its inputs, its hold, and still air."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.scenario import Wind
from aerodrake.systems.wind_force import WindForce

JOINTS, PERIOD = 6, 0.01
BREEZE = Wind(velocity_m_s=(2.0, 0.0, 0.0))


def make_simulator(config: Wind, vehicle, air, v_B) -> tuple[WindForce, Simulator]:
    """Returns the system with fixed inputs: velocity of the air, and a base in trim that moves."""
    system = WindForce(config, JOINTS, PERIOD, is_windy=True)
    simulator = Simulator(system)
    context = simulator.get_context()
    state = vehicle.trim_state
    state[16:19] = v_B
    system.GetInputPort("true_state").FixValue(context, state)
    system.GetInputPort("air_velocity").FixValue(context, air)
    return system, simulator


@pytest.mark.parametrize(
    ("air", "v_B", "force"),
    [
        ((2, 0, 0), (0, 0, 0), (1.3, 0, 0)),
        ((0, 0, 0), (0, 2, 0), (0, -1.3, 0)),
        ((2, 1, 0), (2, 1, 0), (0, 0, 0)),
        ((3, 0, 1), (0, 0, -3), (4.2, 0, 5.6)),
    ],
)
def test_force_for_relative_velocities(vehicle, air, v_B, force):
    system, simulator = make_simulator(BREEZE, vehicle, air, v_B)
    simulator.AdvanceTo(PERIOD / 2)
    measured = system.GetOutputPort("wind_force").Eval(simulator.get_context())
    np.testing.assert_allclose(measured, force, atol=1e-14)


def test_the_generalized_force_has_no_torque(vehicle):
    system, simulator = make_simulator(BREEZE, vehicle, (3, 0, 4), (0, 0, 0))
    for expected in ((0, 0, 0), (4.2, 0, 5.6)):
        generalized = system.GetOutputPort("generalized_force").Eval(simulator.get_context())
        np.testing.assert_array_equal(np.delete(generalized, [3, 4, 5]), np.zeros(3 + JOINTS))
        np.testing.assert_allclose(generalized[3:6], expected, atol=1e-14)
        simulator.AdvanceTo(PERIOD / 2)


def test_it_is_held_between_samples(vehicle):
    system, simulator = make_simulator(BREEZE, vehicle, (2, 0, 0), (0, 0, 0))
    context = simulator.get_context()
    simulator.AdvanceTo(PERIOD / 2)
    system.GetInputPort("air_velocity").FixValue(context, [-1, 0, 0])
    for time, force in ((0.9 * PERIOD, 1.3), (1.1 * PERIOD, -0.4)):
        simulator.AdvanceTo(time)
        measured = system.GetOutputPort("wind_force").Eval(context)
        np.testing.assert_allclose(measured, [force, 0, 0], atol=1e-14)


def test_no_feedthrough():
    assert not WindForce(BREEZE, JOINTS, PERIOD, is_windy=True).HasAnyDirectFeedthrough()


def test_in_still_air_it_has_no_events_and_evaluates_no_input(vehicle):
    """Its inputs are unconnected."""
    system = WindForce(Wind(), JOINTS, PERIOD, is_windy=False)
    simulator = Simulator(system)
    simulator.AdvanceTo(1.0)
    assert simulator.get_num_discrete_updates() == 0
    np.testing.assert_array_equal(
        system.GetOutputPort("wind_force").Eval(simulator.get_context()), 0
    )

"""Effects of the air on the rotors as a system."""

import numpy as np

from aerodrake.model.vehicle.rotor_air import RotorAir, rotor_forces
from aerodrake.scenario import Air
from aerodrake.systems.rotor_air import RotorAirSystem, make_rotor_air

AIR = Air(rotor_drag_n_s_m=0.3, inflow_s_m=0.1, rotor_radius_m=0.2, ceiling_m=2.0)
THRUST, WIND = np.array([9.0, 10.0, 8.0, 9.5]), np.array([1.0, -0.5, 0.2])


def test_there_is_no_system_without_effects(vehicle):
    assert make_rotor_air(Air(), vehicle) is None
    assert isinstance(make_rotor_air(Air(inflow_s_m=0.1), vehicle), RotorAirSystem)


def test_outputs_are_those_of_the_equations(vehicle):
    system = make_rotor_air(AIR, vehicle)
    context = system.CreateDefaultContext()
    for name, value in (
        ("thrust", THRUST),
        ("true_state", vehicle.trim_state),
        ("wind_velocity", WIND),
    ):
        system.GetInputPort(name).FixValue(context, value)
    expected = rotor_forces(RotorAir.make(AIR, vehicle.rotors), THRUST, WIND, vehicle.trim_state)
    np.testing.assert_array_equal(system.GetOutputPort("thrust").Eval(context), expected.thrust)
    force = system.GetOutputPort("generalized_force").Eval(context)
    np.testing.assert_array_equal(force, [*expected.drag, *np.zeros(vehicle.joints)])
    system.GetInputPort("wind_velocity").FixValue(context, np.zeros(3))
    assert not system.GetOutputPort("generalized_force").Eval(context).any()

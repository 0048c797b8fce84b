"""Wind at the place of the vehicle as a system."""

import numpy as np

from aerodrake.scenario import Wind
from aerodrake.systems.wind_field import WindFieldSystem


def test_the_wind_is_that_at_the_base(vehicle):
    """The base is at 1.5 m, a quarter of the reference height."""
    config = Wind(velocity_m_s=(2.0, 0.0, 0.0), shear_exponent=0.5, reference_height_m=6.0)
    system = WindFieldSystem(config, vehicle.joints)
    context = system.CreateDefaultContext()
    system.GetInputPort("air_velocity").FixValue(context, [2.5, 0.3, 0.0])
    system.GetInputPort("true_state").FixValue(context, vehicle.trim_state)
    np.testing.assert_allclose(system.get_output_port().Eval(context), [1.5, 0.3, 0.0])

"""Wiring of the wind: noise, moving air, and the force on the base."""

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import AffineSystem, RandomSource

from aerodrake.model.vehicle.wind import discrete_gusts, is_at_rest, is_uniform
from aerodrake.scenario import Wind
from aerodrake.support.arguments import Count, Period, checked
from aerodrake.systems.wind_field import WindFieldSystem
from aerodrake.systems.wind_force import WindForce
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs, shared_input

WIRING = Wiring(
    connections=(
        ("gust_noise", "output", "air", "u0"),
        ("air", "y0", "wind_force", "air_velocity"),
    ),
    inputs=shared_input("true_state", "wind_force"),
    outputs=(
        ("air", "y0", "wind_velocity"),
        *outputs("wind_force", "wind_force", "generalized_force"),
    ),
)


@checked
def make_wind(
    config: Wind, joints: Count, period: Period, replacements: Replacements | None = None
) -> Diagram:
    """Makes the wind; in still air it is the same diagram and exerts no force.

    Input: `true_state` (13 + 2 n), a `VehicleState`.
    Outputs: `wind_velocity` (3) m/s, of the air at the base, and `wind_force` (3) N on the base,
    in the world; `generalized_force` (6 + n), the same force on the velocities of the plant.

    Args:
        config: Wind, gusts and drag.
        joints: Number n of joints.
        period: s, of gusts and force.
        replacements: Replacements of its systems; None for none.
    """
    a, b = discrete_gusts(config, period)
    builder = (replacements or Replacements()).builder()
    builder.AddNamedSystem("gust_noise", RandomSource(RandomDistribution.kGaussian, len(b), period))
    identity, mean = np.eye(len(b)), np.array(config.velocity_m_s)
    gusts = AffineSystem(A=a * identity, B=np.diag(b), C=identity, y0=mean, time_period=period)
    gusts.configure_random_state(np.diag(np.square(config.gust_m_s)))  # Stationary from the start.
    air = builder.AddNamedSystem("air", gusts)
    is_windy = air is not gusts or not is_at_rest(config)  # A replacement may always blow.
    builder.AddNamedSystem("wind_force", WindForce(config, joints, period, is_windy))
    wiring = WIRING
    if not is_uniform(config):
        builder.AddNamedSystem("wind_field", WindFieldSystem(config, joints))
        wiring = wiring.insert("wind_field", ("air", "y0"), "air_velocity", "wind_velocity")
        wiring += Wiring(inputs=shared_input("true_state", "wind_field"))
    return wiring.build(builder, "wind")

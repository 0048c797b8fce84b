"""The wind as a diagram: noise, moving air, and the force on the base."""

from __future__ import annotations

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import AffineSystem, RandomSource

from aerodrake.model.vehicle.wind import discrete_gusts, is_at_rest
from aerodrake.scenario import Wind
from aerodrake.systems.wind_force import WindForce
from aerodrake.wiring.replacements import Replacements


def make_wind(
    config: Wind, joints: int, period: float, replacements: Replacements | None = None
) -> Diagram:
    """Air that moves past the base. At rest it is the same diagram, and exerts no force.

    Input: `true_state` (13 + 2 n).
    Outputs: `wind_force` (3) N in the world, and `generalized_force` (6 + n), the same for
    a plant.

    Args:
        config: Wind, gusts and drag.
        joints: n.
        period: s, of gusts and force.
        replacements: Of systems in it.
    """
    a, b = discrete_gusts(config, period)
    builder = (replacements or Replacements()).builder()
    gust_noise = builder.AddNamedSystem(
        "gust_noise", RandomSource(RandomDistribution.kGaussian, len(b), period)
    )
    gusts = AffineSystem(
        A=a * np.eye(len(b)),
        B=np.diag(b),
        C=np.eye(len(b)),
        y0=np.array(config.velocity_m_s),
        time_period=period,
    )
    gusts.configure_random_state(np.diag(np.square(config.gust_m_s)))  # They have always blown.
    air = builder.AddNamedSystem("air", gusts)
    moves = air is not gusts or not is_at_rest(config)  # Of another's air nothing is known.
    wind_force = builder.AddNamedSystem("wind_force", WindForce(config, joints, period, moves))
    builder.Connect(gust_noise.get_output_port(), air.get_input_port())
    builder.Connect(air.get_output_port(), wind_force.GetInputPort("air_velocity"))
    builder.ExportInput(wind_force.GetInputPort("true_state"), "true_state")
    for port in ("wind_force", "generalized_force"):
        builder.ExportOutput(wind_force.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("wind")
    return diagram

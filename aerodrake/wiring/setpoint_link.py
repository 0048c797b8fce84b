"""Wiring of the setpoint link: its random draws, and the messages."""

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import RandomSource

from aerodrake.model.actuation.setpoint_messages import LinkTiming
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.systems.setpoint_link import SetpointLink
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs, shared_input

WIRING = Wiring(
    connections=(("setpoint_draws", "output", "messages", "draws"),),
    inputs=shared_input("segment", "messages"),
    outputs=outputs("messages", "base_setpoint", "joint_setpoint"),
)


@checked
def make_setpoint_link(
    scenario: Scenario, vehicle: VehicleModel, replacements: Replacements | None = None
) -> Diagram | None:
    """Makes the link from the coordinator to the station; None without latency and loss.

    Input: `segment` (3 (3 + n) + 1) of the coordinator.
    Outputs: `base_setpoint` (9) and `joint_setpoint` (3 n), as the station receives them.

    Args:
        scenario: Latency and loss, rates, and the supervisor's number of ticks without a plan.
        vehicle: The scenario's vehicle.
        replacements: Replacements of its systems; None for none.
    """
    config, period = scenario.actuation, scenario.rates.mpc_period_s
    if max(config.setpoint_latency_s) == 0 and config.setpoint_loss == 0:
        return None
    builder = (replacements or Replacements()).builder()
    draws = RandomSource(RandomDistribution.kUniform, 2, period)
    builder.AddNamedSystem("setpoint_draws", draws)
    timing = LinkTiming.make(config, period, scenario.supervisor.plan_ticks)
    trim = np.concatenate([vehicle.p_B, vehicle.working])
    builder.AddNamedSystem("messages", SetpointLink(timing, trim))
    return WIRING.build(builder, "setpoint_link")

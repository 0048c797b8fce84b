"""Scenario of a mounted arm, with comments on its values."""

from dataclasses import dataclass

import numpy as np

from aerodrake.mounting.request import Request
from aerodrake.mounting.sizing import Multirotor
from aerodrake.mounting.working import Working
from aerodrake.scenario import Allocation
from aerodrake.scenario.plain_yaml import dump_line

EDGE = 0.5
"""d_edge over the farthest reach from p_O, as in the packaged scenarios."""
LEAST_EDGE = 2.0
"""Smallest d_edge over d_h; with a smaller arm d_h and the learning space shrink."""
AMPLITUDE_M, LAP_S = 0.4, 18.0
"""Amplitude of the clover, and time of a lap."""
TEMPLATE = """\
# Vehicle of `{command}`. Fly it: aerodrake run {name}.yaml
duration: 24.0 # s: smooth start, one lap, and some more
vehicle:
  robot: {name}.urdf # relative to this file
  # Arm and legs start {clearance:.1f} m above the ground.
  base_position_m: [0.0, 0.0, {height}]
{working}
  working_rad: {angles}
  rotor:
    # Hover takes {hover:.0%} of it.
    max_thrust_n: {thrust:g}
    # In proportion to the radius of a rotor, {disc:.2f} m.
    torque_ratio_m: {ratio:g}
    # Likewise, but not faster than the packaged vehicle's rotors. Set what yours have.
    lag_up_s: {rise:g}
    lag_down_s: {fall:g}
reference:
  kind: clover
  amplitude_m: {amplitude}
  lap_s: {lap}
  start_s: 3.0
allocation:
  # Half of the tool's farthest reach from its place in the working configuration, {reach:.2f} m.
  d_edge_m: {edge}
{space}"""
SPACE = """\
  # In proportion to d_edge_m, which is small.
  d_h_m: {d_h}
  learning_space_m: {size}
"""


@dataclass(frozen=True)
class Start:
    """Start of a flight.

    Attributes:
        height: m, of the base.
        clearance: m, between the ground and the lowest part of the vehicle.
        reach: m, farthest distance of the tool from its initial position in the base frame.
        hover: Share of the rotors' largest thrust in hover.
    """

    height: float
    clearance: float
    reach: float
    hover: float


def scenario_yaml(request: Request, multirotor: Multirotor, working: Working, start: Start) -> str:
    """Returns the text of the scenario.

    Args:
        request: The request for the vehicle.
        multirotor: The multirotor.
        working: The arm's working configuration.
        start: The start of the flight.
    """
    edge = float(f"{EDGE * start.reach:.2g}")
    space = ""
    if edge < LEAST_EDGE * Allocation.d_h_m:
        d_h = edge / LEAST_EDGE
        shrunk = np.array(Allocation.learning_space_m) * d_h / Allocation.d_h_m
        space = SPACE.format(d_h=round(d_h, 4), size=np.maximum(shrunk, 0.01).round(3).tolist())
    return TEMPLATE.format(
        command=" ".join(request.command.splitlines()),
        name=request.name,
        clearance=start.clearance,
        height=start.height,
        working="\n".join(f"  # {line}" for line in working.lines()),
        angles=dump_line(working.q.tolist()),
        hover=start.hover,
        thrust=multirotor.max_thrust,
        disc=multirotor.disc,
        ratio=multirotor.torque_ratio,
        rise=multirotor.lag[0],
        fall=multirotor.lag[1],
        amplitude=AMPLITUDE_M,
        lap=LAP_S,
        reach=start.reach,
        edge=edge,
        space=space,
    )

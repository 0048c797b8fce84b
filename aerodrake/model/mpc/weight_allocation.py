"""Weight allocation between base and arm motion (paper, section III-C)."""

import math
from enum import IntEnum
from typing import NamedTuple

from aerodrake.scenario import Allocation

HYSTERESIS = 0.1
"""Relative hysteresis: a boundary d crossed inward is crossed outward at (1 + HYSTERESIS) d."""

ADJUSTMENT_GAMMA_FLOOR = 0.2
"""Lower bound of |gamma| in w_m in adjustment mode, so that the arm can recentre."""


class Mode(IntEnum):
    """Motion modes of the aerial manipulator."""

    FLIGHT = 0
    COORDINATED = 1
    HOVER = 2
    ADJUSTMENT = 3

    @property
    def label(self) -> str:
        """Name in logs and summaries."""
        return self.name.lower()


class AllocatedWeights(NamedTuple):
    """Output of the weight allocator.

    Attributes:
        gamma: In [-1, 1], metric of the desired arm motion.
        mode: The motion mode, a value of `Mode`.
        w_q: Factor on W_2 of the base.
        w_m: Factor on W_2 of the joints.
        w_d: Factor on W_4.
    """

    gamma: float
    mode: float
    w_q: float
    w_m: float
    w_d: float


def next_mode(config: Allocation, last: Mode, d_e: float, d_o: float, d_g: float) -> Mode:
    """Returns the mode, by the cases of the paper's gamma in their printed order.

    Beyond the paper, boundaries have hysteresis, and the mode is COORDINATED if the
    end-effector is on a target trajectory that is too large for hovering.

    Args:
        config: Boundaries.
        last: The current mode.
        d_e: m, distance from the end-effector to its target.
        d_o: m, distance from the end-effector to the centre of the learning space.
        d_g: m, maximum diameter of the target trajectory.
    """

    def beyond(d: float, boundary: float, was_beyond: bool) -> bool:
        return d > boundary if was_beyond else d > (1 + HYSTERESIS) * boundary

    can_hover = d_g < config.d_h_m
    d_f = config.d_h_m if can_hover else config.d_f_m
    if beyond(d_e, d_f, last is Mode.FLIGHT):
        return Mode.FLIGHT
    if beyond(d_o, config.d_h_m, last is Mode.ADJUSTMENT):
        return Mode.ADJUSTMENT
    return Mode.HOVER if can_hover else Mode.COORDINATED


def allocate(
    config: Allocation, last: Mode, d_e: float, d_o: float, d_g: float
) -> AllocatedWeights:
    """Returns gamma and the weights (paper, eq. 10, 11). The distances are those of `next_mode`.

    With `config.kind` "fixed", the mode is reported but not used: the weights are those of
    `fixed_gamma` at d_o = d_h / 2.
    """
    mode = next_mode(config, last, d_e, d_o, d_g)
    if config.kind == "fixed":
        return _weights(config, mode, config.fixed_gamma, config.d_h_m / 2, 0.0)
    d_h = config.d_h_m
    if mode is Mode.FLIGHT:
        gamma = 0.0
    elif mode is Mode.HOVER:
        gamma = 1.0
    elif mode is Mode.COORDINATED:
        gamma = (config.k_mp + d_h) / (config.k_mp + max(d_e, d_h))
    else:
        gamma = max(-config.k_mn * (d_o - d_h) / (config.d_edge_m - d_h), -1.0)
    floor = ADJUSTMENT_GAMMA_FLOOR if mode is Mode.ADJUSTMENT else 0.0
    return _weights(config, mode, gamma, d_o, floor)


def _weights(
    config: Allocation, mode: Mode, gamma: float, d_o: float, floor: float
) -> AllocatedWeights:
    return AllocatedWeights(
        gamma=gamma,
        mode=mode,
        w_q=config.k_q * (gamma**2 + 0.1),
        w_m=config.k_m / (max(math.fabs(gamma), floor) + 0.01),
        w_d=config.k_d * max(d_o, config.d_o_floor_m) / (1.1 + gamma),
    )

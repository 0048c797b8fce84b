"""Weight allocation between base and arm motion (paper, section III-C)."""

import math
from enum import IntEnum
from typing import NamedTuple

from aerodrake.scenario import Allocation

ADJUSTMENT_GAMMA_FLOOR = 0.2
"""Lower bound of |gamma| in w_m in adjustment mode; not in the paper."""


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
    """Returns the mode: the first case of the table in `allocate` whose condition holds.

    With `config.hysteresis` h, a mode beyond a boundary d is entered at (1 + h) d and left at d.

    Args:
        config: Boundaries.
        last: The current mode.
        d_e: m, distance from the end-effector to the current target point p_Ed(t).
        d_o: m, distance from the end-effector to the centre of the learning space.
        d_g: m, maximum diameter of the target trajectory.
    """

    def beyond(d: float, boundary: float, was_beyond: bool) -> bool:
        return d > boundary if was_beyond else d > (1 + config.hysteresis) * boundary

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

    The mode is that of the first case whose condition holds, with d_f = d_h if d_g < d_h:

        case         condition                   gamma
        FLIGHT       d_e > d_f                   0
        ADJUSTMENT   d_o > d_h                   max(-k_mn (d_o - d_h) / (d_edge - d_h), -1)
        HOVER        d_g < d_h                   1
        COORDINATED  otherwise                   (k_mp + d_h) / (k_mp + max(d_e, d_h))

              printed                            computed
        w_q   k_q (gamma^2 + 0.1)                as printed
        w_m   k_m / (gamma + 0.01)               k_m / (max(|gamma|, floor) + 0.01)
        w_d   k_d d_o / (1.1 + gamma)            k_d max(d_o, d_o_floor) / (1.1 + gamma)

    with floor = 0.2 in ADJUSTMENT and 0 otherwise. Differences from the paper:

    - w_m: the printed value is negative for gamma < -0.01. |gamma| follows the paper's text: as
      |gamma| increases, w_m decreases. Without the floor, w_m is near 100 k_m just beyond d_h,
      and the arm cannot recentre.
    - w_d: at d_o = 0 the printed value is 0, and J_4 vanishes.
    - gamma: beyond d_edge the printed value is less than -1, outside the paper's [-1, 1], and w_d
      is unbounded or negative.
    - Cases: the printed ones overlap for d_e > d_f and d_o >= d_h; the first one in their printed
      order applies. None covers d_e <= d_h and d_o < d_h with d_g >= d_h, on a target trajectory
      that is too large for hovering; it is COORDINATED with d_e raised to d_h, so gamma = 1.
    - Boundaries have the hysteresis of `next_mode`. With `config.hysteresis` 0 they are as
      printed, except that ADJUSTMENT excludes d_o = d_h, at which its gamma is 0.

    With `config.kind` "fixed", the mode is reported but not used: the weights are those of
    `fixed_gamma` at d_o = d_h / 2, with floor = 0.
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

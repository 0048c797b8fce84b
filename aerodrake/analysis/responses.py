"""Responses of the tool to disturbances of the base and to sensor noise."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StepResponse:
    """Motion of the tool after a step of one disturbance.

    Attributes:
        input: `force_x` to `force_z` (N, in the world, at the base's origin) or `torque_x` to
            `torque_z` (N m, in the world).
        unit: `m/N` or `m/(N m)`.
        time_s: (T,) s since the step.
        values: (T, 3) position of the tool along x, y, z for a step of one unit.
        peak: Largest distance, in `unit`.
        settling_s: s after which the tool stays within 2 % of the peak from its final position;
            None if it does not settle within the time shown.
    """

    input: str
    unit: str
    time_s: np.ndarray
    values: np.ndarray
    peak: float
    settling_s: float | None


@dataclass(frozen=True)
class FrequencyResponse:
    """Gain from a group of inputs to the position of the tool.

    Attributes:
        input: `force`, `torque` (of the base), `position_noise`, `velocity_noise`,
            `attitude_noise`, `rate_noise` or `joint_noise` (added to samples).
        unit: Of the gain, such as `m/N` or `m/rad`.
        hz: (F,) frequencies up to the Nyquist frequency.
        magnitude: (F,) largest singular value of the transfer matrix from all axes, or joints, of
            the group to the tool's three axes.
        peak: Largest magnitude.
        peak_hz: Its frequency.
    """

    input: str
    unit: str
    hz: np.ndarray
    magnitude: np.ndarray
    peak: float
    peak_hz: float

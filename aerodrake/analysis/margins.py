"""Stability margins of the sampled closed loop."""

from dataclasses import dataclass


@dataclass(frozen=True)
class StabilityLimit:
    """Value at which the loop becomes unstable.

    Attributes:
        value: s for a delay, else a factor.
        frequency_hz: Frequency of the mode that becomes unstable.
    """

    value: float
    frequency_hz: float


@dataclass(frozen=True)
class StabilityMargin:
    """Range of a delay or gain within which the closed loop is stable.

    Attributes:
        name: `base_delay`: additional delay of the base's measurements, as `sensors.base_delay_s`.
            `rotor_gain`: factor on the deviation of each rotor's thrust from trim, as
            `mismatch.thrust_scale`. `joint_gain`: factor on the deviation of each joint's torque
            from trim, as `mismatch.torque_scale`.
        kind: `delay` in s, or `gain`.
        nominal: The value without effect: 0 s, or 1.
        end: (smallest, largest) value of the search.
        lower: The largest limit below the nominal value; None if there is none in the range.
        upper: The smallest limit above it; None if there is none in the range. Both are None for
            a loop that is unstable at the nominal value.
    """

    name: str
    kind: str
    nominal: float
    end: tuple[float, float]
    lower: StabilityLimit | None
    upper: StabilityLimit | None

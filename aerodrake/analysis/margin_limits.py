"""Search for the stability margins of a linear loop."""

from collections.abc import Callable, Sequence

import numpy as np

from aerodrake.analysis.linear_loop import LinearLoop, Variation
from aerodrake.analysis.margins import StabilityLimit, StabilityMargin
from aerodrake.analysis.modes import NEUTRAL_1_S, exponent_of

LONGEST_DELAY_S = 0.2
"""s, end of the search for the delay margin."""

GAINS = (0.1, 10.0)
"""Ends of the search for gain margins."""

RATIO = 1.12
"""Ratio of successive gains, and of delays above ten plant steps, at which stability is tested."""

PRECISION = 1e-3
"""Relative precision of a gain's limit; a delay is a whole number of plant steps."""

Varied = Callable[[float], Variation]


def find_margins_of(loop: LinearLoop) -> tuple[StabilityMargin, ...]:
    """Returns the margins of base delay, rotor gain and joint gain.

    Each limit is the first value, from the nominal one outwards, at which an eigenvalue leaves the
    unit circle: it lies between two values of which only the first is stable.
    """
    step_s = loop.period.dt / loop.period.steps
    longest = round(LONGEST_DELAY_S / step_s)
    steps = sorted({*range(11), *(round(RATIO**k) for k in range(200))})
    delays = [float(step) for step in steps if step <= longest]
    low, high = GAINS
    count = round(np.log(high) / np.log(RATIO))
    up, down = np.geomspace(1.0, high, count + 1), np.geomspace(1.0, low, count + 1)
    base_delay = _limit(loop, lambda steps: Variation(delay_steps=round(steps)), delays, 1.0)
    if base_delay is not None:
        base_delay = StabilityLimit(base_delay.value * step_s, base_delay.frequency_hz)
    margins = [
        StabilityMargin(
            "base_delay", "delay", 0.0, (0.0, longest * step_s), lower=None, upper=base_delay
        )
    ]
    varied: dict[str, Varied] = {
        "rotor_gain": lambda gain: Variation(rotor_gain=gain),
        "joint_gain": lambda gain: Variation(joint_gain=gain),
    }
    for name, vary in varied.items():
        lower, upper = (_limit(loop, vary, gains, PRECISION) for gains in (down, up))
        margins.append(StabilityMargin(name, "gain", 1.0, GAINS, lower, upper))
    return tuple(margins)


def _limit(
    loop: LinearLoop, vary: Varied, values: Sequence[float], precision: float
) -> StabilityLimit | None:
    """Returns the first limit along values from the nominal one on; None without one.

    Args:
        loop: The loop.
        vary: Returns the variation of a value.
        values: Values to test.
        precision: Largest distance of the limit from a stable value, relative if below 1.
    """

    def is_stable(value: float) -> bool:
        z = np.linalg.eigvals(loop.matrices(vary(value)).A)
        return bool(np.log(np.abs(z).max()) / loop.period.dt <= NEUTRAL_1_S)

    stable = values[0]
    if not is_stable(stable):
        return None
    for unstable in values[1:]:
        if is_stable(unstable):
            stable = unstable
            continue
        while abs(unstable - stable) > precision * (1.0 if precision >= 1 else unstable):
            middle = (stable + unstable) / 2
            stable, unstable = (middle, unstable) if is_stable(middle) else (stable, middle)
        return StabilityLimit(float(unstable), _frequency_hz(loop, vary(unstable)))
    return None


def _frequency_hz(loop: LinearLoop, variation: Variation) -> float:
    """Returns the frequency of the fastest growing mode of a variation."""
    period = loop.matrices(variation)
    values, vectors = np.linalg.eig(period.A)
    critical = np.argmax(np.abs(values))
    exponent = exponent_of(values[critical], vectors[:, critical], period)
    return exponent.imag / (2 * np.pi * loop.period.dt)

"""Search for the stability margins of a linear loop."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import eig

from aerodrake.analysis.linear_loop import LinearLoop, Variation
from aerodrake.analysis.margins import StabilityLimit, StabilityMargin
from aerodrake.analysis.modes import are_stable, exponent_of

LONGEST_DELAY_S = 0.2
"""s, end of the search for the delay margin."""

GAINS = (0.1, 10.0)
"""Ends of the search for gain margins."""

RATIO = 1.12
"""Ratio of successive gains, and of delays above ten plant steps, at which stability is tested."""

PRECISION = 1e-3
"""Relative precision of a gain's limit. A delay is a whole number of plant steps."""

Between = Callable[[float, float], float | None]
"""Function of a stable and an unstable value: the next one to test between them, None if none."""

Varied = Callable[[float], Variation]
"""Function of a delay or gain: the variation of the loop with it."""


def stability_margins(loop: LinearLoop) -> tuple[StabilityMargin, ...]:
    """Returns the margins of base delay, rotor gain and joint gain.

    Each limit is the first value, from the nominal one outwards, at which an eigenvalue leaves the
    unit circle: it lies between two values of which only the first is stable.
    """
    step_s = loop.period.dt / loop.period.steps
    longest = round(LONGEST_DELAY_S / step_s)
    delays = sorted({*range(11), *(round(RATIO**k) for k in range(100))})
    delays = [steps for steps in delays if steps <= longest]
    base_delay = _limit(loop, lambda steps: Variation(delay_steps=steps), delays, _between_steps)
    if base_delay is not None:
        base_delay = StabilityLimit(base_delay.value * step_s, base_delay.frequency_hz)
    end_s = longest * step_s
    margins = [StabilityMargin("base_delay", "delay", 0.0, (0.0, end_s), None, base_delay)]
    varied: dict[str, Varied] = {
        "rotor_gain": lambda gain: Variation(rotor_gain=gain),
        "joint_gain": lambda gain: Variation(joint_gain=gain),
    }
    count = round(np.log(max(GAINS)) / np.log(RATIO))
    for name, vary in varied.items():
        lower, upper = (
            _limit(loop, vary, np.geomspace(1.0, end, count + 1).tolist(), _between_gains)
            for end in GAINS
        )
        margins.append(StabilityMargin(name, "gain", 1.0, GAINS, lower, upper))
    return tuple(margins)


def _between_steps(stable: int, unstable: int) -> int | None:
    """Returns a number of steps between two; None if they are adjacent."""
    return (stable + unstable) // 2 if unstable - stable > 1 else None


def _between_gains(stable: float, unstable: float) -> float | None:
    """Returns a gain between two; None if they are as close as `PRECISION`."""
    is_close = abs(unstable - stable) <= PRECISION * unstable
    return None if is_close else (stable + unstable) / 2


def _limit(
    loop: LinearLoop, vary: Varied, values: Sequence[float], between: Between
) -> StabilityLimit | None:
    """Returns the first limit along values from the nominal one on; None without one.

    Args:
        loop: The loop.
        vary: Variation of a value.
        values: Values to test.
        between: Next value to test between a stable and an unstable one.
    """

    def is_stable(value: float) -> bool:
        z = np.linalg.eigvals(loop.matrices(vary(value)).A)
        return bool(_are_stable(loop, z).all())

    stable = values[0]
    if not is_stable(stable):
        return None
    for unstable in values[1:]:
        if is_stable(unstable):
            stable = unstable
            continue
        while (middle := between(stable, unstable)) is not None:
            stable, unstable = (middle, unstable) if is_stable(middle) else (stable, middle)
        return StabilityLimit(float(unstable), _frequency_hz(loop, vary(unstable)))
    return None


def _are_stable(loop: LinearLoop, z: np.ndarray) -> np.ndarray:
    """Returns True for each eigenvalue of a stable mode."""
    with np.errstate(divide="ignore"):  # Deadbeat states have z = 0.
        exponents = np.log(z.astype(complex)) / loop.period.dt
    return are_stable(exponents, loop.period.fastest)


def _frequency_hz(loop: LinearLoop, variation: Variation) -> float:
    """Returns the frequency of the fastest growing mode of a variation."""
    period = loop.matrices(variation)
    values, left, right = eig(period.A, left=True, right=True)
    i = np.argmax(np.where(_are_stable(loop, values), 0.0, np.abs(values)))
    exponent = exponent_of(values[i], left[:, i], right[:, i], period)
    return exponent.imag / (2 * np.pi * loop.period.dt)

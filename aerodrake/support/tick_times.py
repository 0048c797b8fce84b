"""Wall times of a controller's ticks, measured from outside."""

import time
from typing import Any


def time_ticks(controller: Any) -> list[float]:
    """Times each call of a `KinematicController`'s method `solve_tick`, by wrapping it.

    Returns:
        List to which each call appends its wall time in ms, which never feeds back into the
        simulation. It remains empty for a system without that method.
    """
    times_ms: list[float] = []
    if solve_tick := getattr(controller, "solve_tick", None):

        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            solution = solve_tick(*arguments)
            times_ms.append(1e3 * (time.perf_counter() - start))
            return solution

        controller.solve_tick = timed
    return times_ms

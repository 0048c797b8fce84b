"""Wall times of a controller's ticks, measured from outside."""

import time
from typing import Any


class TickTimer:
    """Measures the wall time of each call of a controller's `solve_tick`.

    It wraps that method of one object. A controller without it is not timed. The times never
    feed back into the simulation.

    Attributes:
        times_ms: Wall time of each call so far.

    Args:
        controller: A system with a method `solve_tick`, such as a `KinematicController`.
    """

    def __init__(self, controller: Any):
        self.times_ms: list[float] = []
        solve_tick = getattr(controller, "solve_tick", None)
        if solve_tick is None:
            return

        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            solution = solve_tick(*arguments)
            self.times_ms.append(1e3 * (time.perf_counter() - start))
            return solution

        controller.solve_tick = timed

"""Points that are spread evenly, the same at every call."""

import numpy as np


def spread(count: int, dimensions: int) -> np.ndarray:
    """Returns the first points (count, d) of the Halton sequence in a unit cube."""
    from scipy.stats.qmc import Halton  # Importing it takes a third of a second.

    return Halton(dimensions, scramble=False).random(count)

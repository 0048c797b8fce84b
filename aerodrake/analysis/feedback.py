"""States in a feedback loop with the plant."""

import numpy as np
from scipy.sparse.csgraph import connected_components


def in_loop(acts: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Returns the indices of the states from and to which there are paths from given ones.

    Args:
        acts: (N, N), not zero where one state acts on another, in either order.
        nodes: (K,) indices of the given states, which count as one.
    """
    # A node with edges from and to all given ones is in their strongly connected component.
    given = np.isin(np.arange(len(acts)), nodes)[:, None]
    graph = np.block([[acts, given], [given.T, np.zeros((1, 1))]])
    _, components = connected_components(graph, connection="strong")
    return np.flatnonzero(components[:-1] == components[-1])

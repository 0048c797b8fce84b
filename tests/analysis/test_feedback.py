"""States in a loop with others."""

import numpy as np

from aerodrake.analysis.feedback import in_loop


def test_only_states_on_a_path_from_and_to_the_given_ones_are_in_their_loop():
    """0 -> 1 -> 2 -> 0 is a loop; 3 only receives, 4 only acts, 5 and 6 are a loop of their own."""
    acts = np.zeros((7, 7), dtype=bool)
    for source, target in ((0, 1), (1, 2), (2, 0), (1, 3), (4, 1), (5, 6), (6, 5)):
        acts[source, target] = True
    assert in_loop(acts, np.array([0])).tolist() == [0, 1, 2]
    assert in_loop(acts.T, np.array([0])).tolist() == [0, 1, 2]


def test_given_states_count_as_one():
    """0 -> 2 and 2 -> 1: the state 2 is on a path between the given ones."""
    acts = np.zeros((4, 4), dtype=bool)
    acts[0, 2] = acts[2, 1] = acts[0, 3] = True
    assert in_loop(acts, np.array([0, 1])).tolist() == [0, 1, 2]

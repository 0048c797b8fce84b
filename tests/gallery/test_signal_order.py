"""Orders of systems: as few signals fed back as any order has."""

from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.gallery.signal_order import signal_order


def fed_back(order, signals) -> int:
    """Signals with a target before their source, counted one by one."""
    place = {system: i for i, system in enumerate(order)}
    return sum(any(place[t] < place[source] for t in targets) for source, targets in signals)


def signals_of(count):
    targets = st.frozensets(st.integers(0, count - 1), min_size=1)
    return st.lists(st.tuples(st.integers(0, count - 1), targets), max_size=8)


@pytest.mark.parametrize(
    ("signals", "order"),
    [
        ([], (0, 1, 2)),
        ([(2, {1}), (1, {0})], (2, 1, 0)),
        # A loop is cut where one signal closes it, not two.
        ([(0, {1}), (0, {1}), (1, {2}), (1, {2}), (2, {0})], (0, 1, 2)),
        ([(2, {0}), (2, {0}), (0, {1}), (0, {1}), (1, {2})], (2, 0, 1)),
        # One signal for two targets is fed back once, two signals for one target twice.
        ([(0, {1, 2}), (1, {0}), (2, {0})], (1, 2, 0)),
        # Of equal ones, the order with the longer path: 0, 1, 2 in a chain.
        ([(0, {1}), (1, {2}), (2, {0})], (0, 1, 2)),
        ([(1, {1}), (1, {0})], (1, 0, 2)),
    ],
)
def test_order(signals, order):
    assert signal_order([(s, frozenset(t)) for s, t in signals], 3) == order


@settings(max_examples=30, deadline=None)
@given(signals_of(5))
def test_no_order_feeds_back_fewer_signals(signals):
    order = signal_order(signals, 5)
    assert sorted(order) == list(range(5))
    assert fed_back(order, signals) == min(fed_back(o, signals) for o in permutations(range(5)))


def test_more_systems_than_sets_that_are_kept():
    """A chain of 24 systems, then a ring of them."""
    order = [7 * i % 24 for i in range(24)]
    chain = [(a, frozenset({b})) for a, b in zip(order, order[1:], strict=False)]
    assert signal_order(chain, 24) == tuple(order)
    ring = [*chain, (order[-1], frozenset({order[0]}))]
    assert fed_back(signal_order(ring, 24), ring) == 1

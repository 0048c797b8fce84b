"""Order of systems along their signals: sources first, with few signals fed back."""

from collections.abc import Collection
from typing import NamedTuple

MOST_ORDERS = 300
"""Number of sets of systems whose best order is kept; all of them for up to ten systems."""


class Order(NamedTuple):
    """Order of the first systems; the smaller of two is the better one.

    Attributes:
        fed_back: Number of signals with a target that is not behind their source.
        depth: Minus the sum of the systems' ranks; the rank of a system is the length of the
            longest path of signals to it.
        inversions: Number of pairs of systems in another order than their diagram has.
        systems: Indices of the systems.
        ranks: Rank of each.
    """

    fed_back: int
    depth: int
    inversions: int
    systems: tuple[int, ...]
    ranks: tuple[int, ...]


def signal_order(signals: Collection[tuple[int, frozenset[int]]], count: int) -> tuple[int, ...]:
    """Returns the order of systems in which the fewest signals are fed back.

    Of several, it is one with long paths of signals, close to the given order. Sets of systems
    are extended by one system at a time, each set in its best order (dynamic programming; a beam
    search if there are more than `MOST_ORDERS` sets).

    Args:
        signals: Source and targets of each signal.
        count: Number of systems; they are 0 to `count` - 1.
    """
    fed = [[_bits(own - {v}) for source, own in signals if source == v] for v in range(count)]
    sources = [{s for s, targets in signals if v in targets} for v in range(count)]
    best = {0: Order(0, 0, 0, (), ())}
    for _ in range(count):
        longer: dict[int, Order] = {}
        for placed, order in best.items():
            for system in range(count):
                if placed >> system & 1:
                    continue
                ranks = dict(zip(order.systems, order.ranks, strict=True))
                rank = 1 + max((ranks[s] for s in sources[system] if s in ranks), default=-1)
                new = Order(
                    order.fed_back + sum(bool(targets & placed) for targets in fed[system]),
                    order.depth - rank,
                    order.inversions + sum(other > system for other in order.systems),
                    (*order.systems, system),
                    (*order.ranks, rank),
                )
                both = placed | 1 << system
                longer[both] = min(new, longer.get(both, new))
        best = dict(sorted(longer.items(), key=lambda item: item[1])[:MOST_ORDERS])
    return min(best.values()).systems


def _bits(systems: Collection[int]) -> int:
    return sum(1 << system for system in systems)

"""Rates of systems as data."""

from typing import NamedTuple


class Rate(NamedTuple):
    """Periodic events that several systems have in common.

    Attributes:
        systems: Their names; a scenario may have only some of them.
        period: Key of the scenario's `rates`.
        offset_steps: Offset from the multiples of the period, in steps of the plant.
        kind: `discrete` or `unrestricted`; at one instant Drake runs unrestricted updates first.
    """

    systems: tuple[str, ...]
    period: str
    offset_steps: float = 0.0
    kind: str = "discrete"

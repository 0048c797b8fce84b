"""Analysis of a scenario's closed loop."""

from collections.abc import Callable, Sequence

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.scenario import Scenario


def analyze_hover(scenario: Scenario) -> OperatingPoint:
    """Returns the sampled closed loop of a scenario in hover, without margins and responses.

    Raises:
        BadInput: if the scenario cannot be flown.
    """
    raise NotImplementedError


def analyze_loop(
    scenario: Scenario,
    times: Sequence[float] = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Analysis:
    """Analyses the sampled closed loop of a scenario in hover and along its path.

    The loop is linearised without noise and gusts, and with the unconstrained MPC.

    Args:
        scenario: The scenario to analyse.
        times: s, reference times at which to linearise along the path, in any order.
        progress: Called with the name of each step as it begins.

    Raises:
        BadInput: if the scenario cannot be flown, or a time is not within the flight.
    """
    raise NotImplementedError

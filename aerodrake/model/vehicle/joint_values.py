"""Values of the joints from a scenario's list of one value, or one per joint."""

import numpy as np

from aerodrake.support.errors import ScenarioError


def per_joint(values: tuple[float, ...], joints: int, source: str, key: str) -> np.ndarray:
    """Returns (n,) values for n = `joints`.

    Args:
        values: One value, or n.
        joints: n.
        source, key: The scenario and the dotted key, named in errors.

    Raises:
        ScenarioError: if the list has another length.
    """
    if len(values) not in (1, joints):
        problem = f"expected 1 value, or {joints}, one for each joint, got {len(values)}"
        raise ScenarioError(source, key, problem)
    return np.broadcast_to(np.array(values, dtype=float), joints)

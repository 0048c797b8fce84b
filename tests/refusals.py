"""Scenarios that cannot be used, and what is said of them."""

import pytest

from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import ScenarioError


def refuses(path: str, *overrides: tuple[str, str]) -> str:
    """The message about a scenario that cannot be used."""
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, overrides)
    message = str(caught.value)
    assert len(message) < 2000 and message.isprintable()
    return message

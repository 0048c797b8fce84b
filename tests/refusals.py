"""Check that a scenario is refused."""

import pytest

from aerodrake.scenario.load import load_with_options
from aerodrake.support.errors import ScenarioError


def refuses(path: str, *overrides: tuple[str, str]) -> str:
    """Returns the message with which a scenario is refused."""
    with pytest.raises(ScenarioError) as caught:
        load_with_options(path, overrides)
    message = str(caught.value)
    assert len(message) < 2000 and message.isprintable()
    return message

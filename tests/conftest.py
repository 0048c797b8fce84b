"""What many tests share: the default flight and its vehicle, and repeatable properties."""

import hypothesis
import pytest

from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Scenario

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    return Scenario()


@pytest.fixture(scope="session")
def vehicle(scenario) -> Vehicle:
    return Vehicle.load(scenario)

"""What all tests share: the default flight and its vehicle, and repeatable properties."""

import hypothesis
import pytest
from threadpoolctl import threadpool_limits

from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Scenario

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")


@pytest.fixture(scope="session", autouse=True)
def _single_thread():
    """Threads that wait for each other cost more than the small matrices here."""
    with threadpool_limits(limits=1):
        yield


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    return Scenario()


@pytest.fixture(scope="session")
def vehicle(scenario) -> Vehicle:
    return Vehicle.load(scenario)

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


@pytest.fixture(scope="session")
def short_flight():
    """A scenario that has something of everything, and the log of its flight of 0.6 s."""
    from aerodrake.reference_kinds import Clover
    from aerodrake.scenario import Residual, Scenario
    from aerodrake.simulate import Flight

    scenario = Scenario(
        name="short",
        duration=0.5,
        settle_s=0.1,
        reference=Clover(start_s=0.2),
        residual=Residual(mode="online"),
    )
    return scenario, Flight(scenario).fly()

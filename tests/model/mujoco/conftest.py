"""Vehicles in both engines, with payload and mismatch."""

from dataclasses import replace

import pytest

from aerodrake.scenario import Mismatch, Payload, Scenario
from aerodrake.scenario.load import load_scenario
from tests.mujoco_vehicles import BothEngines
from tests.urdfs import DIAGRAMS

CHANGES = {
    "mismatch": Mismatch(mass_scale=1.3, inertia_scale=0.8, centre_of_mass_m=(0.01, -0.02, 0.005)),
    "payload": Payload(mass_kg=0.15),
}


@pytest.fixture(scope="session")
def packaged() -> BothEngines:
    """The packaged vehicle, as its controllers know it."""
    return BothEngines.make(Scenario())


@pytest.fixture(scope="session")
def loaded() -> BothEngines:
    """The packaged vehicle with payload and mismatch."""
    return BothEngines.make(Scenario(**CHANGES))


@pytest.fixture(scope="session")
def four_joints() -> BothEngines:
    """Six rotors and an arm of four joints, with payload and mismatch."""
    scenario = load_scenario(str(DIAGRAMS / "clover_arm4.yaml"))
    return BothEngines.make(replace(scenario, **CHANGES))


@pytest.fixture(params=["packaged", "loaded", "four_joints"])
def both(request: pytest.FixtureRequest) -> BothEngines:
    """Each of the vehicles."""
    return request.getfixturevalue(request.param)

import dataclasses

import pytest
from pydrake.lcm import DrakeLcm

from aerodrake.scenario import (
    LearnerNan,
    Model,
    Mpc,
    MpcMissed,
    Push,
    Rates,
    ReferenceNan,
    Residual,
    Scenario,
    Waypoints,
    Wind,
)
from aerodrake.scenario.fingerprint import COORDINATED, coordinated, plant_hash, scenario_hash
from aerodrake.support.errors import ScenarioError
from aerodrake.support.files import locate
from aerodrake.wire.companion import Companion


def test_the_hash_is_of_all_keys_but_the_name(scenario):
    assert scenario_hash(scenario) == scenario_hash(dataclasses.replace(scenario, name="x"))
    assert scenario_hash(scenario) != scenario_hash(dataclasses.replace(scenario, seed=1))


def test_the_plant_hash_is_of_vehicle_controllers_and_model(scenario):
    same = dataclasses.replace(scenario, mpc=Mpc(horizon=7), wind=Wind((1.0, 0.0, 0.0)))
    assert plant_hash(scenario) == plant_hash(same)
    assert plant_hash(scenario) != plant_hash(
        dataclasses.replace(scenario, model=Model(k_b=(2.0, 1.8, 1.8)))
    )


def test_the_plant_hash_is_of_the_content_of_the_robots_file(tmp_path, scenario):
    copy = tmp_path / "other.urdf"
    original = locate(scenario.vehicle.robot).read_bytes()
    copy.write_bytes(original)
    moved = dataclasses.replace(
        scenario, vehicle=dataclasses.replace(scenario.vehicle, robot=str(copy))
    )
    assert plant_hash(moved) == plant_hash(Scenario())
    copy.write_bytes(original + b"\n")
    assert plant_hash(moved) != plant_hash(Scenario())


class RecordingScenario:
    """A scenario that records which sections are read."""

    __class__ = Scenario  # For isinstance.

    def __init__(self, scenario):
        self._scenario, self.read = scenario, set()

    def __getattr__(self, name):
        self.read.add(name)
        return getattr(self._scenario, name)


def test_coordinated_are_the_sections_that_a_coordinator_reads(monkeypatch):
    """Except for the seed of an untrained network and the source, which is for messages."""
    monkeypatch.setattr("aerodrake.wire.remote_coordinator.coordinated", lambda scenario: {})
    read = set()
    for controller in ("mpc", "clik"):
        scenario = RecordingScenario(
            Scenario(controller=controller, residual=Residual(mode="online"))
        )
        Companion(scenario, DrakeLcm("memq://"))
        read |= scenario.read
    assert read == {*COORDINATED, "seed", "source"}


@pytest.mark.parametrize(
    "change, differing",
    [
        ({"rates": Rates(mpc_period_s=0.04)}, ["rates"]),
        ({"mpc": Mpc(horizon=7), "settle_s": 1.0}, ["settle_s", "mpc"]),
        ({"wind": Wind((1.0, 0.0, 0.0)), "seed": 5, "duration": 1.0, "name": "x"}, []),
        ({"faults": (Push(),)}, []),
        ({"faults": (Push(), MpcMissed())}, ["faults"]),
        ({"faults": (LearnerNan(),)}, ["faults"]),
        ({"faults": (ReferenceNan(start_s=1.0),)}, ["faults"]),
    ],
)
def test_a_change_is_found_by_section(scenario, change, differing):
    own, other = coordinated(scenario), coordinated(dataclasses.replace(scenario, **change))
    assert tuple(own) == tuple(other) == COORDINATED
    assert [name for name in own if own[name] != other[name]] == differing
    assert all(float(number).is_integer() and 0 <= number < 2**48 for number in own.values())


def test_hashes_are_of_the_content_of_files(scenario, tmp_path):
    content = locate(scenario.vehicle.robot).read_bytes()
    numbers = []
    for name in ("first", "second"):
        robot, path = tmp_path / f"{name}.urdf", tmp_path / f"{name}.csv"
        robot.write_bytes(content)
        path.write_text("t,x,y,z\n0,0,0.2,1.2\n1,0,0.2,1.3\n")
        vehicle = dataclasses.replace(scenario.vehicle, robot=str(robot))
        own = dataclasses.replace(scenario, vehicle=vehicle, reference=Waypoints(str(path)))
        numbers.append(coordinated(own))
    assert numbers[0] == numbers[1]
    assert numbers[0]["vehicle"] == coordinated(scenario)["vehicle"]
    path.write_text("t,x,y,z\n0,0,0.2,1.2\n1,0,0.2,1.4\n")
    changed = coordinated(own)
    assert {name for name in changed if changed[name] != numbers[1][name]} == {"reference"}
    path.unlink()
    with pytest.raises(ScenarioError, match="reference.file: "):
        coordinated(own)

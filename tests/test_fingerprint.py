import dataclasses

from aerodrake.files import locate
from aerodrake.fingerprint import plant_hash, scenario_hash
from aerodrake.scenario import Model, Mpc, Scenario
from aerodrake.world import Wind


def test_the_name_is_no_part_of_a_scenario_and_all_else_is(scenario):
    assert scenario_hash(scenario) == scenario_hash(dataclasses.replace(scenario, name="x"))
    assert scenario_hash(scenario) != scenario_hash(dataclasses.replace(scenario, seed=1))


def test_a_plant_is_vehicle_controllers_and_model_but_neither_mpc_nor_weather(scenario):
    same = dataclasses.replace(scenario, mpc=Mpc(horizon=7), wind=Wind((1.0, 0.0, 0.0)))
    assert plant_hash(scenario) == plant_hash(same)
    assert plant_hash(scenario) != plant_hash(
        dataclasses.replace(scenario, model=Model(k_b=(2.0, 1.8, 1.8)))
    )


def test_a_robot_is_what_its_file_says_wherever_it_lies(tmp_path, scenario):
    copy = tmp_path / "other.urdf"
    original = locate(scenario.vehicle.robot).read_bytes()
    copy.write_bytes(original)
    moved = dataclasses.replace(
        scenario, vehicle=dataclasses.replace(scenario.vehicle, robot=str(copy))
    )
    assert plant_hash(moved) == plant_hash(Scenario())
    copy.write_bytes(original + b"\n")
    assert plant_hash(moved) != plant_hash(Scenario())

"""Files that a scenario names are copied before the flight."""

from dataclasses import replace
from pathlib import Path

import pytest

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import AxisAlong, Residual, Scenario, Waypoints
from aerodrake.scenario import Vehicle as Section
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.scenario.inputs import copy_inputs, frozen
from aerodrake.scenario.load import load_scenario, save_scenario
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.support.files import locate

CSV = "t,x,y,z\n0,0,0.2,1.2\n1,0,0.2,1.3\n"


@pytest.fixture
def own(tmp_path) -> Scenario:
    """Scenario with its own robot and mesh, and two CSV files of the same name."""
    folder = tmp_path / "own"
    (folder / "looks").mkdir(parents=True)
    (folder / "looks" / "cube.obj").write_text("v 0 0 0\n")
    (folder / "looks" / "cube.mtl").write_text("newmtl a\n")
    (folder / "other").mkdir()
    text = locate(Section().robot).read_text()
    mesh = '<visual><geometry><mesh filename="looks/cube.obj"/></geometry></visual></link>'
    (folder / "mine.urdf").write_text(text.replace("</link>", mesh, 1))
    (folder / "a.csv").write_text(CSV)
    (folder / "other" / "a.csv").write_text("t,ax,ay,az\n0,0,0,-1\n1,0,0.1,-1\n")
    return Scenario(
        name="own",
        reference=Waypoints(file=str(folder / "a.csv")),
        orientation=AxisAlong(file=str(folder / "other" / "a.csv")),
        vehicle=Section(robot=str(folder / "mine.urdf")),
        source="flight.yaml",
    )


def files(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_meshes_and_files_of_the_same_name_are_copied(own, tmp_path):
    copies = copy_inputs(own, tmp_path / "copies")
    assert files(tmp_path / "copies") == [
        "a.csv", "mine-meshes/0/cube.mtl", "mine-meshes/0/cube.obj", "mine.urdf"
    ]  # fmt: skip
    assert copies.orientation.file == str(tmp_path / "copies-2" / "a.csv")
    assert Path(copies.orientation.file).read_text().startswith("t,ax")
    assert Path(copies.reference.file).read_text() == CSV
    assert copies.vehicle.robot == str(tmp_path / "copies" / "mine.urdf")
    assert VehicleModel.load(copies).joint_names == VehicleModel.load(own).joint_names


def test_a_saved_scenario_is_self_contained(own, tmp_path):
    folders = [tmp_path / name for name in ("first", "second")]
    for folder in folders:
        folder.mkdir()
    first = load_scenario(str(save_scenario(own, folders[0])))
    (tmp_path / "own").rename(tmp_path / "gone")
    second = load_scenario(str(save_scenario(first, folders[1])))
    assert files(folders[0]) == files(folders[1])
    for name in files(folders[0]):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes(), name
    assert plant_hash(first) == plant_hash(second)
    VehicleModel.load(second)


def test_later_changes_of_the_files_have_no_effect(own):
    with frozen(own) as flown:
        for file in (own.reference.file, own.vehicle.robot):
            Path(file).write_text("spoilt")
        assert Path(flown.reference.file).read_text() == CSV
        VehicleModel.load(flown)
        home = Path(flown.reference.file).parent
    assert not home.exists()


def test_errors_name_the_original_file(own):
    Path(own.vehicle.robot).write_text("<robot name='x'><link name='base'/></robot>")
    with pytest.raises(ScenarioError) as caught, frozen(own) as flown:
        VehicleModel.load(flown)
    assert caught.value.key == "vehicle.robot"
    assert str(caught.value).startswith(f"flight.yaml: vehicle.robot: {own.vehicle.robot}: ")


def test_an_unreadable_file_is_not_copied(own, tmp_path):
    """A flight that does not use it succeeds."""
    missing = replace(own, residual=Residual(mode="off", checkpoint=str(tmp_path / "none.pt")))
    copies = copy_inputs(missing, tmp_path / "copies")
    assert copies.residual.checkpoint == str(tmp_path / "none.pt")
    (tmp_path / "run").mkdir()
    assert load_scenario(str(save_scenario(missing, tmp_path / "run"))).residual.mode == "off"


def test_packaged_files_are_not_copied(tmp_path):
    assert copy_inputs(Scenario(), tmp_path / "copies") == Scenario()
    assert files(tmp_path) == []


def test_a_full_disk_is_reported(own, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(BadInput, match="cannot be written: No space left"), frozen(own):
        pass

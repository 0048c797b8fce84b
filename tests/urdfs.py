"""Changed copies of the example URDFs, and their refusals."""

from dataclasses import replace
from pathlib import Path

import pytest

import aerodrake
from aerodrake.model.vehicle.robot import RobotDescription
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput

PACKAGED = (Path(aerodrake.__file__).parent / "robots" / "quadrotor_arm6.urdf").read_text()
"""The packaged robot, with a six-joint arm."""
DIAGRAMS = Path(__file__).parents[1] / "diagrams"
HEXAROTOR = (DIAGRAMS / "hexarotor_arm4.urdf").read_text()
"""The example of a robot of one's own, with a four-joint arm."""


def changed(text: str, old: str, new: str) -> str:
    """Returns the text with the last occurrence of a part replaced."""
    assert old in text
    return new.join(text.rsplit(old, 1))


def refusal(text: str, folder: Path) -> str:
    """Returns the message with which a URDF is refused; it begins with the file's name."""
    path = folder / "robot.urdf"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        RobotDescription.read(str(path))
    source, _, message = str(caught.value).partition("robot.urdf: ")
    assert source == f"{folder}/" and message.isprintable()
    return message


def with_urdf(text: str, folder: Path, **changes: object) -> Scenario:
    """Returns the hexarotor's scenario with another URDF and other keys of the vehicle."""
    path = folder / "robot.urdf"
    path.write_text(text)
    scenario = load_scenario(str(DIAGRAMS / "clover_arm4.yaml"))
    return replace(scenario, vehicle=replace(scenario.vehicle, robot=str(path), **changes))


def vehicle_refusal(text: str, folder: Path, **changes: object) -> str:
    """Returns the message with which a vehicle is refused, without the scenario's file."""
    with pytest.raises(BadInput) as caught:
        VehicleModel.load(with_urdf(text, folder, **changes))
    message = str(caught.value)
    assert "bazel" not in message and "Failure at" not in message and message.isprintable()
    return message.partition("clover_arm4.yaml: ")[2]

"""Drake's warnings are logged once, with the file's name, and its errors say no place in it."""

import logging

import pytest
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.drake_log import warn_once
from aerodrake.model.vehicle.drake_parser import parse_urdf
from aerodrake.support.errors import BadInput

LINK = """<link name="arm"><inertial><mass value="{mass}"/>
<inertia ixx="1" iyy="1" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


def urdf(mass: float = 1, izz: float = 1, more: str = "") -> str:
    return f'<robot name="r">{LINK.format(mass=mass, izz=izz)}{more}</robot>'


@pytest.fixture
def logged(caplog):
    warn_once.cache_clear()
    caplog.set_level(logging.WARNING, "drake")
    return lambda: [record.getMessage() for record in caplog.records]


def test_warnings_are_logged_once_with_the_name_of_the_file(logged):
    hand = LINK.format(mass=1, izz=1).replace("arm", "hand")
    joint = (
        '<joint name="j" type="revolute"><parent link="arm"/><child link="hand"/>'
        '<dynamics friction="0.1"/></joint>'
    )
    for _ in range(2):
        parse_urdf(MultibodyPlant(0.0), urdf(more=hand + joint), "/some/folder/robot.urdf")
    (message,) = logged()
    assert message.startswith(
        "robot.urdf: A joint has specified a non-zero value for the 'friction"
    )


@pytest.mark.parametrize(("mass", "izz"), [(0, 1), (-1, 1), (1, 3)])
def test_an_inertia_that_would_be_replaced_is_refused(mass, izz, logged):
    with pytest.raises(BadInput, match="robot.urdf: expected physical inertias: While") as caught:
        parse_urdf(MultibodyPlant(0.0), urdf(mass, izz), "robot.urdf")
    assert "bazel" not in str(caught.value) and not logged()


def test_errors_are_named_after_the_file():
    twice = '<material name="red"><color rgba="1 0 0 1"/></material>' * 2
    with pytest.raises(BadInput) as caught:
        parse_urdf(MultibodyPlant(0.0), urdf(more=twice), "robot.urdf")
    message = str(caught.value)
    assert message.startswith("robot.urdf: cannot be parsed: Material 'red' was previously defined")

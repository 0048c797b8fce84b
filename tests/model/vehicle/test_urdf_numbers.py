"""Numbers of a URDF: any malformed one is refused, any spelling of a good one is accepted."""

import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.vehicle.robot import RobotDescription
from aerodrake.scenario import Scenario, Vehicle
from tests.urdfs import HEXAROTOR, PACKAGED, changed, refusal

ElementTree.register_namespace("drake", "https://drake.mit.edu")


def is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def numeric_attributes(robot: ElementTree.Element) -> list[tuple[list[ElementTree.Element], str]]:
    """Returns the path from a child of `robot`, and the name, of each attribute of numbers."""
    found = []

    def visit(path):
        for name, value in path[-1].attrib.items():
            if all(map(is_number, value.split())):
                found.append((path, name))
        for inner in path[-1]:
            visit([*path, inner])

    for element in robot:
        visit([element])
    return found


SIZES = [len(numeric_attributes(ElementTree.fromstring(text))) for text in (PACKAGED, HEXAROTOR)]
BAD = [
    "", " ", "nan", "inf", "-inf", "1e999", "0x1p0", "1_0", "1,5", "1;5", "1.2.3", "--1", "+-1",
    ".", "e5", "1e", "1e5.0", "one", "${x}", "1 kg", "1kg", "1m", "90deg", "1/2", "٣", "1٫5",
    "1 2", "1 2 3 4 5", "1\xa02\xa03", "True", "1f", "1d0", "1e10",
]  # fmt: skip
"""Texts that are no number, or not as many as any attribute has."""


def test_the_files_have_many_numbers():
    assert SIZES[0] > 230 and SIZES[1] > 150


def name_of(path: list[ElementTree.Element]) -> str:
    """Returns the name that the user gave the element, or the joint of a transmission."""
    first = path[0]
    return first.get("name") or first.find("joint").get("name")


@settings(max_examples=80)
@given(data=st.data())
def test_any_malformed_number_is_refused_by_file_element_and_value(data, tmp_path_factory):
    number = data.draw(st.integers(0, 1))
    robot = ElementTree.fromstring((PACKAGED, HEXAROTOR)[number])
    attributes = numeric_attributes(robot)
    path, name = attributes[data.draw(st.integers(0, len(attributes) - 1))]
    words = path[-1].get(name).split()
    broken = data.draw(st.sampled_from(BAD))
    if len(words) > 1 and data.draw(st.booleans()):
        words[data.draw(st.integers(0, len(words) - 1))] = broken
        broken = " ".join(words)
        if len(broken.split()) == len(words) and all(map(is_number, broken.split())):
            broken += "!"
    path[-1].set(name, broken)
    text = ElementTree.tostring(robot, encoding="unicode")
    message = refusal(text, tmp_path_factory.getbasetemp())
    assert name_of(path) in message
    assert name.replace("{https://drake.mit.edu}", "drake:") in message
    assert message.endswith(f", got {' '.join(ascii(broken).split())}")


def respelled(word: str, form: int) -> str:
    """Returns the same number, to the last bit, in another form."""
    value, sign = float(word), "-" if word.startswith("-") else "+"
    digits = word.lstrip("+-")
    forms = (
        f"{sign}{digits}",
        f"{sign}0{digits}",
        f"{value:.17e}",
        f"{value:.17E}",
        repr(value),
        f"{digits}e0" if sign == "+" and "e" not in digits else word,
        f"{digits}." if sign == "+" and digits.isdigit() else word,
        f"{sign}{digits.removeprefix('0')}" if digits.startswith("0.") else word,
    )
    assert float(forms[form]) == value
    return forms[form]


def respelled_urdf(text: str) -> str:
    robot = ElementTree.fromstring(text)
    spaces = (" ", "  ", "\t", "\n", " \r\n ")
    for i, (path, name) in enumerate(numeric_attributes(robot)):
        words = [respelled(w, (i + j) % 8) for j, w in enumerate(path[-1].get(name).split())]
        space = spaces[i % len(spaces)]
        path[-1].set(name, f"{space}{space.join(words)}{space}")
    return ElementTree.tostring(robot, encoding="unicode")


def test_other_spellings_of_the_numbers_fly_as_before(tmp_path):
    """Signs, exponents, leading zeros, and any space around and between them."""
    (tmp_path / "robot.urdf").write_text(respelled_urdf(PACKAGED))
    states = []
    for robot in (str(tmp_path / "robot.urdf"), Vehicle().robot):
        scenario = Scenario(duration=0.1, settle_s=0.0, vehicle=Vehicle(robot=robot))
        log = FlightSimulation(scenario).fly()
        states.append(np.hstack([log["p_B_m"], log["p_E_m"], log["q_rad"]]))
    np.testing.assert_array_equal(*states)


ORIGIN = '<origin xyz="0 0 -0.16"/>'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<mass value="0.08"/>', '<mass value="0"/>', "kg, got '0'; a link without mass"),
        ('<mass value="0.08"/>', '<mass value="-0.08"/>', "positive number in kg, got '-0.08'"),
        ('<mass value="0.08"/>', "<mass>0.08</mass>", "missing; .* got the text '0.08'"),
        ('<mass value="0.08"/>', '<mass vaule="0.08"/>', "'vaule'; did you mean 'value'"),
        ('<mass value="0.08"/>', '<mass value="1e10"/>', r"1e\+09 or less, got '1e10'"),
        (' iyz="0"/>', "/>", "link hand: <inertia iyz>: missing; expected a number in kg m"),
        ('<limit lower="-2.0"', '<limits lower="-2.0"', "<limits>; did you mean <limit>"),
        (ORIGIN, '<origin xzy="0 0 -0.16"/>', "'xzy'; did you mean 'xyz'"),
        (ORIGIN, "<origin>0 0 -0.16</origin>", "attributes xyz, rpy, got the text '0 0 -0.16'"),
        (ORIGIN, '<origin z="-0.16"/>', "<origin>: expected no attribute 'z'; valid: xyz, rpy"),
        ("<drake:gear_ratio", "<gear_ratio", "<gear_ratio>; did you mean <drake:gear_ratio>"),
        ('damping="0.01"', 'damping="-0.01"', "wrist_pitch: <dynamics damping>: .* non-negative"),
        ('damping="0.01"', 'friction="0,1"', "wrist_pitch: <dynamics friction>: .* got '0,1'"),
        ('damping="0.01"', 'dampening="0.1"', "'dampening'; did you mean 'damping'"),
        ('ratio value="200"', 'ratio value="0"', "wrist_pitch: <drake:gear_.* nonzero"),
        ('inertia value="6e-7"', 'inertia value="-1"', "rotor_inertia value>: .* non-negative"),
        ('radius="0.01" length', 'radius="0" length', "link hand, collision: <cylinder radius>"),
        ('radius="0.01" length="0.08"', 'radius="0.01"', "<cylinder length>: missing; expected a"),
        ('rgba="0.86 0.87 0.84 1"', 'rgba="255 0 0 1"', "shell: .*rgba>: expected 4 numbers"),
        ('rgba="0.86 0.87 0.84 1"', 'rgba="1 1 1"', r"4 numbers in \[0, 1\], got '1 1 1'"),
        (
            "</collision>",
            '<drake:proximity_properties><drake:mu_static value="a"/></drake:proximity_properties>'
            "</collision>",
            "link hand, collision: <drake:mu_static value>: expected a non-negative number",
        ),
        (
            "</collision>",
            "<drake_compliance><static_friction>0,5</static_friction></drake_compliance></collision>",
            "link hand, collision: <static_friction>: expected a non-negative number, got '0,5'",
        ),
        (
            "</actuator>",
            "<mechanicalReduction>1:50</mechanicalReduction></actuator>",
            "of joint wrist_pitch: <mechanicalReduction>: expected a nonzero number, got '1:50'",
        ),
    ],
)  # fmt: skip
def test_ranges_and_missing_numbers(old, new, message, tmp_path):
    assert re.search(message, refusal(changed(HEXAROTOR, old, new), tmp_path))


def test_misspelled_elements(tmp_path):
    text = HEXAROTOR.replace("<inertial>", "<intertial>").replace("</inertial>", "</intertial>")
    message = refusal(text, tmp_path)
    assert message == "link base: expected no element <intertial>; did you mean <inertial>?"


def test_a_scale_of_one_number_and_elements_that_are_not_read(tmp_path):
    mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "arm.obj").write_text(mesh)
    text = changed(
        HEXAROTOR,
        '<cylinder radius="0.01" length="0.08"/>',
        '<mesh filename="arm.obj" scale=" 0.01 "/>',
    )
    text = changed(
        text, "</robot>", '<gazebo><mass value="?"/><limit lower="1,2"/></gazebo></robot>'
    )
    (tmp_path / "robot.urdf").write_text(text)
    assert RobotDescription.read(str(tmp_path / "robot.urdf"))

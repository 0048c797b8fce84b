"""Elements of converted arms."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.elements import arm_elements, decimals, filter_element
from aerodrake.mounting.joint import ArmJoint, Limits, Motor
from aerodrake.mounting.link import ArmLink


@given(st.lists(st.floats(-1e9, 1e9), min_size=1))
def test_numbers_keep_twelve_digits(numbers):
    assert list(map(float, decimals(numbers).split())) == pytest.approx(numbers, rel=1e-11, abs=0)


def test_numbers_are_short():
    assert decimals([1.0, 0.1 + 0.2, -0.0, 1e-7, 250000.0]) == "1 0.3 0 1e-07 250000"


def test_transmissions_are_in_the_order_of_the_joints():
    joints = tuple(
        ArmJoint(name, "revolute", *ends, limits=Limits(-1, 1, 2, 3, 4), motor=motor)
        for name, ends, motor in (("second", "bc", None), ("first", "ab", Motor(9, 1e-6)))
    )
    arm = ArmTree("arm", tuple(map(ArmLink, "abc")), joints)
    first, second = [e.toxml() for e in arm_elements(arm, "c") if e.tagName == "transmission"]
    assert '<joint name="first"/>' in first and '<drake:gear_ratio value="9"/>' in first
    assert '<joint name="second"/>' in second and "gear_ratio" not in second


def test_a_filter_group_ignores_itself():
    text = filter_element(["a", "b"]).toxml()
    assert '<drake:member link="b"/>' in text
    assert '<drake:ignored_collision_filter_group name="robot"/>' in text

"""Laws of scaling."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.joint import Limits, Motor
from aerodrake.mounting.scaling import scale
from tests.arm_urdfs import joint, link, read, robot

SHAPES = """<visual><geometry><cylinder radius="0.1" length="0.3"/></geometry></visual>
<collision><origin xyz="1 0 0"/><geometry><box size="1 2 3"/></geometry></collision>"""
LIMIT = """<limit lower="-1" upper="2" effort="8" velocity="3" drake:acceleration="5"/>
<dynamics damping="0.4" friction="0.2"/>"""
MOTOR = """<transmission><joint name="j"/><actuator><drake:gear_ratio value="50"/>
<drake:rotor_inertia value="2e-6"/></actuator></transmission>"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory) -> ArmTree:
    text = robot(link("a"), link("b", 2, SHAPES), joint("j", "a", "b", inner=LIMIT), MOTOR)
    return read(text, tmp_path_factory.mktemp("arm")).arm


def test_laws(arm):
    scaled, (sentence,) = scale(arm, length=0.5, mass=0.1)
    one, two = arm.joints[0], scaled.joints[0]
    assert two.limits == Limits(-1, 2, pytest.approx(0.4), 3, 5)
    assert (two.damping, two.friction) == pytest.approx((0.02, 0.01))
    assert two.motor == Motor(50, pytest.approx(2e-6 * 0.1 * 0.25))
    assert two.origin.xyz == pytest.approx([x / 2 for x in one.origin.xyz])
    assert two.origin.rpy == one.origin.rpy and two.axis == one.axis
    big, small = arm.link("b"), scaled.link("b")
    assert small.mass == pytest.approx(0.2)
    moments = [0.025 * x for x in big.inertial.moments]
    assert small.inertial.moments == pytest.approx(moments)
    assert small.visuals[0].numbers == pytest.approx((0.05, 0.15))
    assert small.collisions[0].numbers == pytest.approx((0.5, 1, 1.5))
    assert small.collisions[0].origin.xyz == pytest.approx((0.5, 0, 0))
    assert "torques and damping by 0.05, inertias by 0.025" in sentence


@given(st.floats(0.01, 100), st.floats(0.01, 100))
def test_scaling_back_gives_the_same_arm(arm, length, mass):
    back = scale(scale(arm, length, mass).arm, 1 / length, 1 / mass).arm
    assert back.mass == pytest.approx(arm.mass) and back.reach("b") == pytest.approx(arm.reach("b"))
    assert back.links[1].inertial.moments == pytest.approx(arm.links[1].inertial.moments)


def test_no_scaling_changes_nothing(arm):
    assert scale(arm) == (arm, ())

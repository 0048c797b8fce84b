"""Inertias: every result is one of a body, and valid ones are kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.tree import RotationalInertia

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.inertias import correct_inertias, physical
from aerodrake.mounting.link import ArmLink, Geometry, Inertial
from aerodrake.mounting.pose import Pose
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import joint, link, read, robot

MOMENT = st.floats(-1, 1).map(lambda x: 0.0 if abs(x) < 1e-9 else x)


@given(st.tuples(*[MOMENT] * 6).filter(any), st.floats(-6, 0))
def test_all_results_are_physical_and_stay(moments, power):
    given_moments = tuple(10**power * x for x in moments)
    corrected = physical(given_moments)
    inertia = RotationalInertia(*corrected)
    assert inertia.CouldBePhysicallyValid()
    principal = inertia.CalcPrincipalMomentsOfInertia()
    assert principal.min() > 1e-8 * principal.max()
    np.testing.assert_allclose(physical(corrected), corrected, rtol=1e-6, atol=1e-9 * principal[2])


@given(st.tuples(*[st.floats(0.1, 1)] * 3), st.tuples(*[st.floats(-0.02, 0.02)] * 3))
def test_inertias_of_bodies_are_kept(squares, products):
    x, y, z = squares
    moments = (y + z, x + z, x + y, *products)
    assert physical(moments) == moments


def test_the_largest_moment_is_kept():
    ixx, iyy, izz, *products = physical((0.1, 0.2, 0.5, 0, 0, 0))
    assert izz == pytest.approx(0.5) and ixx + iyy == pytest.approx(0.5)
    assert iyy - ixx == pytest.approx(0.1) and products == [0, 0, 0]


def test_links_without_mass_or_inertia(tmp_path):
    zero = '<inertial><mass value="{}"/><inertia ixx="0"/></inertial>'
    text = robot(
        link("a", 1.8),
        link("b", 0, zero.format(0.2)),
        link("c", 0, zero.format(0)),
        link("d", 0),
        joint("j", "a", "b"),
        joint("k", "b", "c"),
        joint("f", "b", "d", "fixed"),
    )
    arm, changes = correct_inertias(read(text, tmp_path).arm)
    radius = (3 * 0.2 / (4 * np.pi * 1000)) ** (1 / 3)
    assert arm.link("b").inertial.moments[:3] == pytest.approx([0.4 * 0.2 * radius**2] * 3)
    assert arm.link("c").mass == pytest.approx(0.02) and arm.link("d").inertial is None
    assert changes == (
        "a zero inertia becomes that of a solid sphere of 1000 kg/m^3: b",
        "an <inertial> without mass is removed: c",
        "moving links with no mass from there on get 0.02 kg, 1% of the arm's mass: c",
    )


def test_a_placeholder_becomes_the_inertia_of_a_box():
    box = Geometry(Pose((0, 0, 0.1)), "box", (0.03, 0.04, 0.2))
    for moment, is_kept in ((1.0, False), (0.01, True)):
        given = Inertial(Pose((0, 0, 0.1)), 0.12, (moment, moment, moment, 0.0, 0.0, 0.0))
        arm = ArmTree("arm", (ArmLink("a", given, (box,)), ArmLink("b", given)), ())
        corrected, changes = correct_inertias(arm)
        assert corrected.link("b").inertial == given and is_kept == (not changes)
        expected = [0.0416, 0.0409, 0.0025] if not is_kept else [1, 1, 1]
        factor = 0.01 if not is_kept else moment
        moments = corrected.link("a").inertial.moments
        assert moments[:3] == pytest.approx(factor * np.array(expected), rel=1e-3)


def test_a_link_without_mass_between_others_stays_so(tmp_path):
    """Its joint carries the links below, as in a wrist of joints with one centre."""
    text = robot(link("a"), link("b", 0), link("c"), joint("j", "a", "b"), joint("k", "b", "c"))
    arm, changes = correct_inertias(read(text, tmp_path).arm)
    assert arm.link("b").inertial is None and not changes


def test_an_arm_without_mass_is_refused(tmp_path):
    with pytest.raises(BadInput) as caught:
        correct_inertias(read(robot(link("a", 0)), tmp_path).arm)
    message = str(caught.value)
    assert message.startswith("expected links with a <mass> in their <inertial>, or with geometry")

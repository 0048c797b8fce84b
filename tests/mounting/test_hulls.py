"""Masses that are estimated from geometry."""

import math

import numpy as np
import pytest
import trimesh
from pydrake.multibody.tree import SpatialInertia

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.hulls import estimate_masses
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.link import ArmLink, Geometry, Inertial
from aerodrake.mounting.pose import Pose

BOX = Geometry(Pose((1, 2, 3), (0, 0, math.pi / 2)), "box", (0.1, 0.2, 0.4))


def inertial(*geometries: Geometry) -> Inertial | None:
    """Returns the estimated inertial of a link with collision geometry."""
    arm = ArmTree("arm", (ArmLink("a", collisions=geometries),), ())
    return estimate_masses(arm).arm.links[0].inertial


def test_a_turned_box():
    box = inertial(BOX)
    assert box.mass == pytest.approx(8) and box.origin.xyz == pytest.approx((1, 2, 3))
    moments = 8 / 12 * np.array([0.1**2 + 0.4**2, 0.2**2 + 0.4**2, 0.1**2 + 0.2**2])
    assert box.moments == pytest.approx([*moments, 0, 0, 0], abs=1e-12)


UP = [0, 0, 1]


@pytest.mark.parametrize(
    ("shape", "numbers", "expected"),
    [
        ("sphere", (0.1,), SpatialInertia.SolidSphereWithDensity),
        ("cylinder", (0.1, 0.3), SpatialInertia.SolidCylinderWithDensity),
        ("drake:capsule", (0.1, 0.3), SpatialInertia.SolidCapsuleWithDensity),
        ("drake:ellipsoid", (0.1, 0.2, 0.3), SpatialInertia.SolidEllipsoidWithDensity),
    ],
)
def test_shapes_are_those_of_drake_but_for_facets(shape, numbers, expected):
    solid = expected(1000, *numbers, *([UP] if len(numbers) == 2 else []))
    body = inertial(Geometry(Pose(), shape, numbers))
    assert body.mass == pytest.approx(solid.get_mass(), rel=0.06)
    moments = solid.CalcRotationalInertia().get_moments()
    assert body.moments[:3] == pytest.approx(moments, rel=0.1)


def test_hulls_of_a_link_add_up(tmp_path):
    """A mesh with a hole counts with its hull, in its scale."""
    ring = trimesh.creation.annulus(r_min=0.05, r_max=0.1, height=0.2)
    ring.export(tmp_path / "ring.stl")
    mesh = Geometry(Pose(), "mesh", (1.0, 1.0, -2.0), tmp_path / "ring.stl")
    disc = 1000 * ring.convex_hull.volume * 2
    assert inertial(mesh).mass == pytest.approx(disc)
    assert inertial(mesh, BOX).mass == pytest.approx(disc + 8)


def test_links_without_volume_have_no_mass(tmp_path):
    trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).export(tmp_path / "a.stl")
    flat = Geometry(Pose(), "mesh", (1.0, 1.0, 1.0), tmp_path / "a.stl")
    assert inertial() is inertial(flat) is None


def test_a_link_for_collisions_alone_counts_unless_it_is_fixed_to_a_visible_one():
    """As in the URDFs of Franka."""
    links = ArmLink("a", visuals=(BOX,), collisions=(BOX,)), ArmLink("a_sc", collisions=(BOX, BOX))
    for kind, mass in (("fixed", 8), ("revolute", 8 + 16)):
        arm = ArmTree("arm", links, (ArmJoint("j", kind, "a", "a_sc"),))
        assert estimate_masses(arm).arm.mass == pytest.approx(mass)


def test_visuals_count_and_arms_with_masses_are_kept():
    link = ArmLink("a", visuals=(BOX,))
    arm = ArmTree("arm", (link, ArmLink("b")), ())
    estimated, (sentence,) = estimate_masses(arm)
    assert estimated.mass == pytest.approx(8)
    assert sentence.endswith("in the convex hulls of the links give 8 kg: a 8")
    assert estimate_masses(estimated) == (estimated, ())

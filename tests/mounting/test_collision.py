"""Boxes around links."""

import numpy as np
import pytest
import trimesh

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.collision import box_links, check_meshes, corners
from aerodrake.mounting.link import ArmLink, Geometry
from aerodrake.mounting.pose import Pose
from aerodrake.support.errors import BadInput


def boxed(*collisions: Geometry, visuals: tuple[Geometry, ...] = ()) -> tuple[Geometry, ...]:
    """Returns the collision geometry of a link after the step."""
    arm = ArmTree("arm", (ArmLink("a", None, visuals, collisions),), ())
    return box_links(arm).arm.links[0].collisions


@pytest.mark.parametrize(
    ("shape", "numbers", "size"),
    [
        ("box", (1, 2, 3), (1, 2, 3)),
        ("sphere", (0.5,), (1, 1, 1)),
        ("cylinder", (0.5, 3), (1, 1, 3)),
        ("drake:capsule", (0.5, 3), (1, 1, 4)),
        ("drake:ellipsoid", (1, 2, 3), (2, 4, 6)),
    ],
)
def test_size_of_shapes(shape, numbers, size):
    geometry = Geometry(Pose((1, 0, 0), (0, 0, np.pi / 2)), shape, numbers)
    box = corners(geometry)
    assert np.ptp(box, axis=0) == pytest.approx([size[1], size[0], size[2]])
    assert box.mean(axis=0) == pytest.approx([1, 0, 0])


def test_one_box_contains_all_geometry():
    first = Geometry(Pose((0, 0, 1)), "sphere", (0.5,))
    second = Geometry(Pose((2, 0, 0)), "box", (1.0, 1.0, 1.0))
    (box,) = boxed(first, second)
    assert box.shape == "box" and box.origin.xyz == pytest.approx((1, 0, 0.5))
    assert box.numbers == pytest.approx((3, 1, 2))


def test_a_mesh_counts_with_scale_and_place(tmp_path):
    trimesh.creation.box(bounds=[[0, 0, 0], [1, 2, 3]]).export(tmp_path / "a.stl")
    mesh = Geometry(Pose((0, 0, 1)), "mesh", (-0.5, 1.0, 1.0), tmp_path / "a.stl")
    (box,) = boxed(visuals=(mesh,))
    assert box.origin.xyz == pytest.approx((-0.25, 1, 2.5))
    assert box.numbers == pytest.approx((0.5, 2, 3))


def test_links_without_geometry_or_readable_mesh_have_none(tmp_path):
    (tmp_path / "a.stl").write_text("")
    assert boxed() == boxed(Geometry(Pose(), "mesh", (1, 1, 1), tmp_path / "a.stl")) == ()


def test_a_mesh_in_mm_is_refused(tmp_path):
    trimesh.creation.box((30, 40, 150)).export(tmp_path / "a.stl")
    for scale in (1.0, 0.001):
        mesh = Geometry(Pose(), "mesh", (scale, scale, scale), tmp_path / "a.stl")
        arm = ArmTree("arm", (ArmLink("a", visuals=(mesh,)),), ())
        if scale == 1:
            with pytest.raises(BadInput, match="link a: expected meshes .* got a.stl of 150 m"):
                check_meshes(arm)
        else:
            assert check_meshes(arm).arm is arm


def test_a_flat_mesh_has_a_thin_box(tmp_path):
    trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).export(tmp_path / "a.stl")
    (box,) = boxed(Geometry(Pose(), "mesh", (1.0, 1.0, 1.0), tmp_path / "a.stl"))
    assert box.numbers == pytest.approx((1, 1, 1e-3))

"""Geometry of links: shapes, colours, and what is left out."""

import pytest

from tests.arm_urdfs import link, read, robot

VISUAL = "<visual><geometry>{}</geometry>{}</visual>"


def visuals(shape: str, folder, material: str = "", outside: str = ""):
    """Returns the visual geometry of a link with one shape."""
    text = robot(outside, link("a", 1, VISUAL.format(shape, material)))
    arm, changes = read(text, folder)
    return arm.links[0].visuals, changes


@pytest.mark.parametrize(
    ("shape", "kind", "numbers"),
    [
        ('<box size="1 2 3"/>', "box", (1, 2, 3)),
        ('<sphere radius="2"/>', "sphere", (2,)),
        ('<cylinder length="1" radius="2"/>', "cylinder", (2, 1)),
        ('<capsule length="1" radius="2"/>', "drake:capsule", (2, 1)),
        ('<drake:ellipsoid a="1" b="2" c="3"/>', "drake:ellipsoid", (1, 2, 3)),
        ('<mesh filename="a.stl"/>', "mesh", (1, 1, 1)),
        ('<mesh filename="a.stl" scale="0.001"/>', "mesh", (0.001,) * 3),
        ('<mesh filename="a.stl" scale="1 -1 2"/>', "mesh", (1, -1, 2)),
    ],
)
def test_shapes(shape, kind, numbers, tmp_path):
    (tmp_path / "a.stl").write_text("")
    ((geometry,), changes) = visuals(shape, tmp_path)
    assert (geometry.shape, geometry.numbers) == (kind, numbers) and not changes


@pytest.mark.parametrize(
    "shape", ["", "<plane/>", '<sphere radius="0"/>', '<box size="1 -1 1"/>', "<box/><sphere/>"]
)
def test_unusable_shapes_are_left_out_and_named(shape, tmp_path):
    if shape == "<box/><sphere/>":
        shape = '<box size="1 1 1"/><sphere radius="1"/>'
    geometries, changes = visuals(shape, tmp_path)
    assert geometries == ()
    assert changes == ("geometry without a usable shape is left out: link a, visual",)


def test_missing_meshes_are_named_once(tmp_path):
    mesh = VISUAL.format('<mesh filename="package://x/a.stl"/>', "")
    arm, changes = read(robot(link("a", 1, mesh + mesh), link("b", 1, mesh)), tmp_path)
    assert changes == ("meshes without a file are left out: package://x/a.stl",)
    assert arm.links[0].visuals == ()


def color(rgba: str) -> str:
    return f'<material name="m"><color rgba="{rgba}"/></material>'


@pytest.mark.parametrize(
    ("rgba", "expected"),
    [
        ("0.1 0.2 0.3 0.4", (0.1, 0.2, 0.3, 0.4)),
        ("0.1 0.2 0.3", (0.1, 0.2, 0.3, 1)),
        ("255 0 51 255", (1, 0, 0.2, 1)),
        ("1 -0.1 0 1", (1, 0, 0, 1)),
        ("red", None),
    ],
)
@pytest.mark.parametrize("is_global", [True, False])
def test_colours(rgba, expected, is_global, tmp_path):
    used = '<material name="m"/>' if is_global else color(rgba)
    outside = color(rgba) if is_global else ""
    ((geometry,), _) = visuals('<sphere radius="1"/>', tmp_path, used, outside)
    assert geometry.rgba == expected


def test_an_undefined_material_is_no_colour(tmp_path):
    ((geometry,), _) = visuals('<sphere radius="1"/>', tmp_path, '<material name="steel"/>')
    assert geometry.rgba is None

"""Meshes of all formats: size, place, colour and file."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from pydrake.geometry import Mesh

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.link import ArmLink, Geometry
from aerodrake.mounting.meshes import bounds, load_parts, write_meshes
from aerodrake.mounting.pose import Pose

BOX = np.array([[-0.05, -0.1, 0.2], [0.15, 0.3, 0.8]])
"""Corners of a box without symmetry."""
DAE = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><unit name="u" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse>
<color>1 0.5 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="{count}">
{points}</float_array><technique_common><accessor source="#pa" count="{rows}" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>
</vertices><triangles count="{faces}" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{indices}</p></triangles></mesh></geometry></library_geometries><library_visual_scenes>
<visual_scene id="s"><node id="n"><translate>0 0 {lift}</translate><instance_geometry url="#g">
<bind_material><technique_common><instance_material symbol="s" target="#m"/></technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def box() -> trimesh.Trimesh:
    """Returns the mesh of the box."""
    return trimesh.creation.box(bounds=BOX)


def dae(unit: float = 1.0, up: str = "Z_UP", lift: float = 0.0) -> str:
    """Returns the box as a COLLADA file in a unit, lowered by a node that lifts it back."""
    mesh = box()
    points = (mesh.vertices - [0, 0, lift]) / unit
    return DAE.format(
        unit=unit,
        up=up,
        lift=lift / unit,
        points=" ".join(map(str, points.ravel())),
        indices=" ".join(map(str, mesh.faces.ravel())),
        count=points.size,
        rows=len(points),
        faces=len(mesh.faces),
    )


def written(file: Path, folder: Path, scale=(1.0, 1.0, 1.0), rgba=None) -> list[Geometry]:
    """Returns the visual geometry that a mesh becomes."""
    visual = Geometry(Pose((1, 2, 3)), "mesh", scale, file, rgba)
    arm = ArmTree("arm", (ArmLink("a", visuals=(visual, visual)),), ())
    link = write_meshes(arm, folder / "meshes").arm.links[0]
    half = len(link.visuals) // 2
    assert link.visuals[:half] == link.visuals[half:]  # A mesh is written once.
    return list(link.visuals[:half])


def drake_bounds(file: Path) -> np.ndarray:
    """Returns the corners (2, 3) m of a mesh as Drake reads it."""
    hull = Mesh(str(file)).GetConvexHull()
    points = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    return np.array([points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("ending", ["stl", "STL", "ply", "obj", "glb", "gltf", "off"])
def test_formats_keep_size_and_place(ending, tmp_path):
    file, mesh = tmp_path / f"link 1.{ending}", box()
    if ending in ("glb", "gltf"):  # Their y axis is up.
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    scene = trimesh.Scene(mesh)
    if ending == "gltf":
        for name, content in scene.export(file_type="gltf").items():
            (tmp_path / name.replace("model.gltf", file.name)).write_bytes(content)
    else:
        (scene if ending == "glb" else mesh).export(file, file_type=ending.lower())
    np.testing.assert_allclose(bounds(file), BOX, atol=1e-6)
    (visual,) = written(file, tmp_path)
    assert visual.file == Path("meshes/link_1.obj") and visual.origin.xyz == (1, 2, 3)
    np.testing.assert_allclose(drake_bounds(tmp_path / visual.file), BOX, atol=1e-6)
    if ending == "gltf":  # Drake turns such files in the same way.
        np.testing.assert_allclose(drake_bounds(file), BOX, atol=1e-6)


@pytest.mark.parametrize(
    ("unit", "up", "lift"),
    [(1.0, "Z_UP", 0.0), (0.001, "Z_UP", 0.5), (0.01, "Y_UP", 0.0), (0.0254, "Z_UP", 0.2)],
)
def test_collada_has_units_nodes_and_colours(unit, up, lift, tmp_path):
    file = tmp_path / "link.dae"
    file.write_text(dae(unit, up, lift))
    np.testing.assert_allclose(bounds(file), BOX, atol=1e-6)
    (visual,) = written(file, tmp_path)
    np.testing.assert_allclose(drake_bounds(tmp_path / visual.file), BOX, atol=1e-6)
    assert visual.rgba == pytest.approx((1, 0.5, 0, 1), abs=3e-3)


def test_scale_is_in_the_file_and_a_mirrored_mesh_is_no_inside_out(tmp_path):
    file, scale = tmp_path / "link.stl", (0.5, -2.0, 1.0)
    box().export(file)
    (visual,) = written(file, tmp_path, scale)
    assert visual.numbers == (1, 1, 1)
    expected = np.sort(BOX * scale, axis=0)
    np.testing.assert_allclose(drake_bounds(tmp_path / visual.file), expected, atol=1e-6)
    assert trimesh.load_mesh(tmp_path / visual.file).volume == pytest.approx(box().volume)


def test_faces_have_normals_that_point_outward(tmp_path):
    """Drake's renderers refuse meshes without normals."""
    box().export(tmp_path / "box.stl")
    (visual,) = written(tmp_path / "box.stl", tmp_path)
    text = (tmp_path / visual.file).read_text().splitlines()
    rows = {
        tag: [line.split()[1:] for line in text if line.startswith(f"{tag} ")]
        for tag in ("v", "vn", "f")
    }
    assert sorted(map(tuple, np.array(rows["vn"], dtype=float).tolist())) == sorted(
        tuple(sign * axis) for axis in np.eye(3) for sign in (-1.0, 1.0)
    )
    vertices, normals = (np.array(rows[tag], dtype=float) for tag in ("v", "vn"))
    for corners in rows["f"]:
        indices = np.array([corner.split("//") for corner in corners], dtype=int) - 1
        a, b, c = vertices[indices[:, 0]]
        assert np.cross(b - a, c - a) @ normals[indices[0, 1]] > 0


def test_a_file_of_several_colours_becomes_one_each(tmp_path):
    left, right = box(), box()
    right.apply_translation([1, 0, 0])
    for mesh, color in ((left, [255, 0, 0, 255]), (right, [0, 0, 255, 128])):
        mesh.visual = trimesh.visual.TextureVisuals(
            material=trimesh.visual.material.PBRMaterial(baseColorFactor=color)
        )
    trimesh.Scene([left, right]).export(tmp_path / "link.glb")
    first, second = written(tmp_path / "link.glb", tmp_path)
    assert first.rgba == pytest.approx((0, 0, 1, 0.502)) and second.rgba == (1, 0, 0, 1)
    assert {first.file.name, second.file.name} == {"link.obj", "link_2.obj"}


@pytest.mark.parametrize("ending", ["obj", "glb"])
def test_a_texture_counts_with_its_mean_colour(ending, tmp_path):
    mesh, image = box(), Image.new("RGB", (2, 1), (255, 0, 0))
    image.putpixel((1, 0), (0, 0, 255))
    mesh.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), image=image)
    trimesh.Scene(mesh).export(tmp_path / f"link.{ending}")
    (visual,) = written(tmp_path / f"link.{ending}", tmp_path)
    assert visual.rgba == (0.5, 0, 0.5, 1)


@pytest.mark.parametrize(("rgba", "expected"), [(None, (0.7, 0.7, 0.7, 1)), ((0, 1, 0, 1),) * 2])
def test_a_mesh_without_colour_has_that_of_the_urdf(rgba, expected, tmp_path):
    box().export(tmp_path / "link.stl")
    assert [visual.rgba for visual in written(tmp_path / "link.stl", tmp_path, rgba=rgba)] == [
        expected
    ]


def test_unreadable_meshes_are_left_out_and_named(tmp_path):
    visuals = []
    for name, content in (("a.dae", "<x>"), ("b.stl", ""), ("c.mesh", "?"), ("d.obj", "v 0 0 0")):
        (tmp_path / name).write_text(content)
        visuals.append(Geometry(Pose(), "mesh", (1.0, 1.0, 1.0), tmp_path / name))
    arm = ArmTree("arm", (ArmLink("a", visuals=tuple(visuals)),), ())
    written, (sentence,) = write_meshes(arm, tmp_path / "meshes")
    assert written.links[0].visuals == ()
    assert sentence == "meshes that cannot be read are left out: a.dae, b.stl, c.mesh, d.obj"


def test_fine_meshes_are_made_coarser(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=6, radius=0.02)
    ball.export(tmp_path / "ball.stl")
    assert len(load_parts(tmp_path / "ball.stl")[0].faces) > 80_000
    (visual,) = written(tmp_path / "ball.stl", tmp_path)
    coarse = trimesh.load_mesh(tmp_path / visual.file)
    assert len(coarse.faces) < 20_000
    np.testing.assert_allclose(coarse.bounds, ball.bounds, atol=1e-3)


def test_a_mesh_smaller_than_the_coarsest_grid_stays(tmp_path):
    trimesh.creation.icosphere(subdivisions=6, radius=2e-4).export(tmp_path / "ball.stl")
    (visual,) = written(tmp_path / "ball.stl", tmp_path, scale=(100.0, 100.0, 100.0))
    coarse = trimesh.load_mesh(tmp_path / visual.file)
    assert np.ptp(coarse.bounds, axis=0) == pytest.approx([0.04] * 3, abs=0.011)


def test_files_differ_in_more_than_capitals(tmp_path):
    for name in ("Link.stl", "link.stl"):
        box().export(tmp_path / name, file_type="stl")
    visuals = tuple(
        Geometry(Pose(), "mesh", (1.0, 1.0, 1.0), tmp_path / name)
        for name in ("Link.stl", "link.stl")
    )
    arm = ArmTree("arm", (ArmLink("a", visuals=visuals),), ())
    link = write_meshes(arm, tmp_path / "meshes").arm.links[0]
    assert [visual.file.name for visual in link.visuals] == ["Link.obj", "link_2.obj"]


def test_a_changed_file_is_read_again(tmp_path):
    file = tmp_path / "link.stl"
    box().export(file)
    before = bounds(file)
    trimesh.creation.icosphere(radius=3).export(file)
    assert np.ptp(bounds(file)) > np.ptp(before)

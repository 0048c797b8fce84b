"""Files behind the URIs of meshes."""

from pathlib import Path

import pytest

from aerodrake.mounting.packages import find_mesh


@pytest.fixture(scope="module")
def workspace(tmp_path_factory) -> Path:
    """Folder with packages `arm` and `hand`, of which `elsewhere/hand2` is out of the way."""
    folder = tmp_path_factory.mktemp("workspace")
    for file in (
        "src/arm/urdf/arm.urdf",
        "src/arm/urdf/beside.stl",
        "src/arm/meshes/link 1.stl",
        "src/hand/meshes/finger.stl",
        "src/renamed-2.1/urdf/arm.urdf",
        "src/renamed-2.1/meshes/own.stl",
        "elsewhere/hand2/meshes/thumb.stl",
    ):
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text("")
    return folder


@pytest.mark.parametrize(
    ("uri", "file"),
    [
        ("beside.stl", "src/arm/urdf/beside.stl"),
        ("../meshes/link 1.stl", "src/arm/meshes/link 1.stl"),
        ("package://arm/meshes/link 1.stl", "src/arm/meshes/link 1.stl"),
        ("package:///arm/meshes/link 1.stl", "src/arm/meshes/link 1.stl"),
        ("package://hand/meshes/finger.stl", "src/hand/meshes/finger.stl"),
        ("package://arm/meshes/Link 1.STL", "src/arm/meshes/link 1.stl"),
        ("..\\meshes\\link 1.stl", "src/arm/meshes/link 1.stl"),
        ("model://hand/meshes/finger.stl", "src/hand/meshes/finger.stl"),
        ("package://hand2/meshes/thumb.stl", None),
        ("package://arm/meshes/absent.stl", None),
        ("package://arm/meshes", None),
        ("https://example.org/a.stl", None),
        ("", None),
    ],
)
def test_files_are_found(uri, file, workspace):
    expected = file and (workspace / file).resolve()
    found = find_mesh(uri, workspace / "src/arm/urdf", ())
    assert (found and found.resolve()) == expected


def test_a_package_may_have_another_folder(workspace):
    folder = workspace / "src/renamed-2.1/urdf"
    found = find_mesh("package://official/meshes/own.stl", folder, ())
    assert found.resolve() == workspace / "src/renamed-2.1/meshes/own.stl"


@pytest.mark.parametrize("home", ["elsewhere", "elsewhere/hand2"])
def test_packages_can_be_given(home, workspace):
    found = find_mesh("package://hand2/meshes/thumb.stl", workspace, (workspace / home,))
    assert found == workspace / "elsewhere/hand2/meshes/thumb.stl"


def test_a_file_uri_is_absolute(workspace):
    file = workspace / "src/arm/meshes/link 1.stl"
    assert find_mesh(file.as_uri(), Path("/"), ()) == file
    assert find_mesh(f"file://{file}", Path("/"), ()) == file

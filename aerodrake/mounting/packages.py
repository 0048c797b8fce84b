"""Files of meshes, looked for in the folders of ROS packages."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from aerodrake.support.files import PACKAGE, locate
from aerodrake.support.urdf import FILE

SCHEMES = ("package://", "model://")
"""Beginnings of URIs in a ROS package or a Gazebo model."""
MAX_LEVELS = 8
"""Number of folders above the URDF that are searched."""


def find_mesh(uri: str, folder: Path, packages: Sequence[Path]) -> Path | None:
    """Returns the file that a URI names; None if there is none.

    A package is looked for in the given folders and in those above the URDF: the folder itself or
    one in it has the name, or contains the file.

    Args:
        uri: Path relative to the URDF, or URI.
        folder: Folder of the URDF.
        packages: Folders of packages, or folders that contain them.
    """
    candidates = list(_candidates(uri.replace("\\", "/"), folder, packages))
    exact = next((path for path in candidates if path.is_file()), None)
    return exact or next(filter(None, map(_of_other_case, candidates)), None)


def _of_other_case(path: Path) -> Path | None:
    """Returns a file that other systems take for the same, since its name has other capitals."""
    if not path.parent.is_dir():
        return None
    name = path.name.lower()
    same = (other for other in sorted(path.parent.iterdir()) if other.name.lower() == name)
    return next((other for other in same if other.is_file()), None)


def _candidates(uri: str, folder: Path, packages: Sequence[Path]) -> Iterator[Path]:
    if uri.startswith(PACKAGE):
        yield locate(uri)
    scheme = next((scheme for scheme in SCHEMES if uri.startswith(scheme)), None)
    if scheme is None:
        path = unquote(uri.removeprefix(FILE)) if uri.startswith(FILE) else uri
        yield folder / path
        return
    name, _, inner = uri.removeprefix(scheme).lstrip("/").partition("/")
    for home in (*packages, folder, *folder.absolute().parents[:MAX_LEVELS]):
        yield home / name / inner
        yield home / inner
        yield home / "share" / name / inner

"""Robot descriptions in files: read without what XML could make of them, and copied whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.dom.minidom import Document, Element
from xml.parsers.expat import ExpatError

from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded

SUFFIX = ".urdf"

MAX_BYTES = 5_000_000
"""No robot description is larger, and none of its meshes ten times so: against hostile files."""

MAX_DEPTH = 50


def read_urdf(path: Path) -> Document:
    """A robot description, in which the meshes beside it are named by absolute URIs.

    Raises:
        BadInput: as `urdf_content` and `parse_urdf`.
    """
    return parse_urdf(path, urdf_content(path))


def urdf_content(path: Path) -> bytes:
    """What is in the file.

    Raises:
        BadInput: if it cannot be read, or is not called a URDF.
    """
    if path.suffix != SUFFIX:
        raise BadInput(path, "", f"expected the path of a URDF, with the ending {SUFFIX}")
    return read_bounded(path, MAX_BYTES)


def parse_urdf(path: Path, content: bytes) -> Document:
    """A robot description, in which the meshes beside its file are named by absolute URIs.

    Args:
        path: Of the file.
        content: Of the file.

    Raises:
        BadInput: if it is no URDF, declares a document type (and with it entities) or is
            nested too deep, if a mesh is no file, or if a joint follows another one.
    """
    try:
        document = _UrdfBuilder().parseString(content)
    except (ExpatError, ValueError, LookupError) as error:
        raise BadInput(path, "", f"cannot be parsed: {error}") from None
    if document.documentElement.tagName != "robot":
        raise BadInput(path, "", "cannot be parsed: expected a URDF, whose root is <robot>")
    for mimic in document.getElementsByTagName("mimic"):
        joint = mimic.parentNode.getAttribute("name")
        raise BadInput(path, "", f"{joint}: expected no <mimic>, since each joint moves by itself")
    for mesh in _local_meshes(document):
        file = path.absolute().parent / mesh.getAttribute("filename").removeprefix("file://")
        if file.exists() and not file.is_file():
            raise BadInput(path, "", f"expected {file} to be a mesh")
        mesh.setAttribute("filename", f"file://{file}")
    return document


def copy_urdf(source: Path, target: Path) -> None:
    """Copies a robot description and the meshes beside it, into a folder beside the copy.

    With each mesh goes what is called like it but for its ending, such as its material.

    Raises:
        BadInput: as `read_urdf`.
        OSError: if it cannot be written.
    """
    document = read_urdf(source)
    homes: dict[Path, str] = {}
    for mesh in _local_meshes(document):
        file = Path(mesh.getAttribute("filename").removeprefix("file://"))
        home = homes.setdefault(file.parent, f"{target.stem}-meshes/{len(homes)}")
        (target.parent / home).mkdir(parents=True, exist_ok=True)
        for part in file.parent.iterdir() if file.is_file() else ():
            if part.stem == file.stem and part.is_file():
                (target.parent / home / part.name).write_bytes(read_bounded(part, 10 * MAX_BYTES))
        mesh.setAttribute("filename", f"{home}/{file.name}")
    # Without meshes it is the same, to the byte.
    content = document.toxml("utf-8") if homes else read_bounded(source, MAX_BYTES)
    target.write_bytes(content)


def _local_meshes(document: Document) -> list[Element]:
    """Those in files, not in packages."""
    meshes = document.getElementsByTagName("mesh")
    files = [(mesh, mesh.getAttribute("filename")) for mesh in meshes]
    return [mesh for mesh, file in files if "://" not in file or file.startswith("file://")]


class _UrdfBuilder(expatbuilder.ExpatBuilder):
    """Knows neither namespaces, since prefixes such as `drake:` go undeclared, nor entities."""

    _depth = 0

    def start_doctype_decl_handler(self, *declaration: Any) -> None:
        raise ExpatError("expected no document type")

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ExpatError(f"expected no more than {MAX_DEPTH} levels")
        super().start_element_handler(name, attributes)

    def end_element_handler(self, name: str) -> None:
        self._depth -= 1
        super().end_element_handler(name)

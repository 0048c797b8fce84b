"""Reading and copying of robot descriptions, without external entities, with their meshes."""

from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.dom.minidom import Document, Element
from xml.parsers.expat import ExpatError

from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded

SUFFIX = ".urdf"

MAX_BYTES = 5_000_000
"""Largest size of a URDF; meshes may be ten times as large. Protects against hostile files."""

MAX_DEPTH = 50


def read_urdf(path: Path) -> Document:
    """Reads a URDF and makes the URIs of local meshes absolute.

    Raises:
        BadInput: if the file cannot be read or does not end in `.urdf`; if its content is not a
            URDF, declares a document type (and so can have entities), is nested too deep, names
            a mesh that is not a file, or has a <mimic>.
    """
    if path.suffix != SUFFIX:
        raise BadInput(path, "", f"expected the path of a URDF, ending in {SUFFIX}")
    try:
        document = _UrdfBuilder().parseString(read_bounded(path, MAX_BYTES))
    except (ExpatError, ValueError, LookupError) as error:
        raise BadInput(path, "", f"cannot be parsed: {error}") from None
    if document.documentElement.tagName != "robot":
        raise BadInput(path, "", "cannot be parsed: expected a URDF, whose root is <robot>")
    for mimic in document.getElementsByTagName("mimic"):
        joint = mimic.parentNode.getAttribute("name")
        raise BadInput(path, "", f"{joint}: expected no <mimic>, since all joints are independent")
    for mesh in _local_meshes(document):
        file = path.absolute().parent / mesh.getAttribute("filename").removeprefix("file://")
        if file.exists() and not file.is_file():
            raise BadInput(path, "", f"expected {file} to be a mesh")
        mesh.setAttribute("filename", f"file://{file}")
    return document


def copy_urdf(source: Path, target: Path) -> None:
    """Copies a URDF, and its local meshes into a folder beside the copy.

    Files with a mesh's name and another ending, such as its material, are copied as well.

    Raises:
        BadInput: as for `read_urdf`.
        OSError: if a copy cannot be written.
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
    # Without meshes the copy is identical.
    content = document.toxml("utf-8") if homes else read_bounded(source, MAX_BYTES)
    target.write_bytes(content)


def _local_meshes(document: Document) -> list[Element]:
    """Returns the elements of meshes in files, not in packages."""
    meshes = document.getElementsByTagName("mesh")
    files = [(mesh, mesh.getAttribute("filename")) for mesh in meshes]
    return [mesh for mesh, file in files if "://" not in file or file.startswith("file://")]


class _UrdfBuilder(expatbuilder.ExpatBuilder):
    """Parser without namespaces, since URDFs do not declare `drake:`, and without entities."""

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

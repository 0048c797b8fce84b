"""Reading and copying of robot descriptions, without external entities, with their meshes."""

import os
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.dom.minidom import Document, Element
from xml.parsers.expat import ExpatError

from aerodrake.support.errors import BadInput
from aerodrake.support.files import PACKAGE, is_packaged, leaves_package, locate, read_bounded
from aerodrake.support.urdf_element import children, owner

SUFFIX = ".urdf"
FILE = "file://"
"""Beginning of the URI of a file outside the package."""

MAX_BYTES = 5_000_000
"""Largest size of a URDF; meshes may be ten times as large. Protects against hostile files."""

MAX_DEPTH = 50

XACRO = "xacro:"
"""Beginning of the names of elements that the command `xacro` expands."""
DEFINITIONS = ("xacro:arg", "xacro:property")
"""Such elements that stand for nothing themselves; exporters leave them in expanded files."""


def read_urdf(path: Path) -> Document:
    """Reads a URDF and makes the URIs of local meshes and textures absolute.

    Raises:
        BadInput: as for `read_document`, or if a mesh or texture does not exist.
    """
    document = read_document(path)
    for element in _with_files(document):
        uri = element.getAttribute("filename")
        if _is_local(uri):
            element.setAttribute("filename", f"{FILE}{_file(path.absolute().parent, uri)}")
        elif not is_packaged(uri) or leaves_package(uri):
            raise _no_file(path, element, uri, "is of another package or scheme")
        file = _file(Path(), element.getAttribute("filename"))
        if not os.path.isfile(file):
            reason = "is no file" if os.path.exists(file) else "does not exist"
            raise _no_file(path, element, uri, reason)
    return document


def read_document(path: Path) -> Document:
    """Reads a URDF as XML.

    Raises:
        BadInput: if the file cannot be read or does not end in `.urdf`; if its content is not a
            URDF, uses macros of xacro, declares a document type (and so can have entities), or is
            nested too deep.
    """
    if path.suffix.lower() != SUFFIX:
        raise BadInput(path, "", f"expected a URDF, whose name ends in {SUFFIX}{_advice(path)}")
    try:
        document = _UrdfBuilder().parseString(read_bounded(path, MAX_BYTES))
    except (ExpatError, ValueError, LookupError) as error:
        raise BadInput(path, "", f"cannot be parsed: {error}") from None
    root = document.documentElement
    if root.tagName != "robot":
        problem = f"cannot be parsed: expected a URDF, whose root is <robot>, got <{root.tagName}>"
        raise BadInput(path, "", problem)
    return document


def _advice(path: Path) -> str:
    """Returns the way to a URDF from another format of robot descriptions."""
    if path.suffix == ".xacro":
        return f": expand it with `xacro {path.name} > robot.urdf`"
    if path.suffix in (".sdf", ".xml", ".mjcf", ".usd"):
        return "; other formats have to be converted"
    return ""


def _no_file(path: Path, element: Element, uri: str, reason: str) -> BadInput:
    """Returns the error of a mesh or texture that cannot be read."""
    return BadInput(
        path,
        owner(element),
        f"<{element.tagName} filename>: expected the path of a file, relative to the URDF or as "
        f"{FILE}..., or {PACKAGE}..., got '{uri}', which {reason}",
    )


def copy_urdf(source: Path, target: Path) -> None:
    """Copies a URDF, and its local meshes into a folder beside the copy.

    Files with a mesh's name and another ending, such as its material, are copied as well.

    Raises:
        BadInput: as for `read_urdf`.
        OSError: if a copy cannot be written.
    """
    document = read_urdf(source)
    homes: dict[Path, str] = {}
    for element in _with_files(document):
        uri = element.getAttribute("filename")
        if not _is_local(uri):
            continue
        file = Path(uri.removeprefix(FILE))
        home = homes.setdefault(file.parent, f"{target.stem}-meshes/{len(homes)}")
        (target.parent / home).mkdir(parents=True, exist_ok=True)
        for part in file.parent.iterdir():
            if part.stem == file.stem and part.is_file():
                (target.parent / home / part.name).write_bytes(read_bounded(part, 10 * MAX_BYTES))
        element.setAttribute("filename", f"{home}/{file.name}")
    # Without meshes the copy is identical.
    content = document.toxml("utf-8") if homes else read_bounded(source, MAX_BYTES)
    target.write_bytes(content)


def _with_files(document: Document) -> list[Element]:
    """Returns the elements that name a mesh or a texture, and that Drake reads."""
    links = list(children(document.documentElement, "link"))
    meshes = [mesh for link in links for mesh in link.getElementsByTagName("mesh")]
    return meshes + [
        texture
        for material in document.getElementsByTagName("material")
        for texture in children(material, "texture")
    ]


def _is_local(uri: str) -> bool:
    return "://" not in uri or uri.startswith(FILE)


def _file(folder: Path, uri: str) -> Path:
    """Returns the path of a mesh or texture; relative ones begin in the folder."""
    return folder / locate(uri.removeprefix(FILE))


class _UrdfBuilder(expatbuilder.ExpatBuilder):
    """Parser without namespaces, since URDFs do not declare `drake:`, and without entities."""

    _depth = 0

    def start_doctype_decl_handler(self, *declaration: Any) -> None:
        raise ExpatError("expected no document type")

    def start_element_handler(self, name: str, attributes: list[str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ExpatError(f"expected no more than {MAX_DEPTH} levels")
        if name.startswith(XACRO) and name not in DEFINITIONS:
            raise ExpatError(f"expected no <{name}>; expand the macros with the command `xacro`")
        super().start_element_handler(name, attributes)

    def end_element_handler(self, name: str) -> None:
        self._depth -= 1
        super().end_element_handler(name)

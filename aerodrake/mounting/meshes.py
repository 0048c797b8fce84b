"""Meshes of other formats, written as the Wavefront files that Drake and the replay draw."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.link import ArmLink, Geometry
from aerodrake.mounting.listed import listed
from aerodrake.mounting.names import UNREADABLE
from aerodrake.support.urdf import MAX_BYTES

if TYPE_CHECKING:
    import trimesh

Y_UP = (".gltf", ".glb")
"""Endings of formats whose y axis is up by definition; Drake turns them like this."""
Z_UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Rotation to z up."""
GREY = (0.7, 0.7, 0.7, 1.0)
"""Colour of meshes without one."""
DIGITS = (6, 4, 3)
"""Decimal digits of unscaled coordinates in m: fewer, if a mesh has too many faces."""
MOST_FACES = 20_000
"""Largest number of faces of a mesh with all digits."""
MOST_MESHES = 128
"""Largest number of meshes in memory."""


class Part(NamedTuple):
    """Part of a mesh with one colour.

    Attributes:
        vertices: (N, 3) m.
        faces: (K, 3) indices of vertices.
        rgba: Colour; None if the file has none.
    """

    vertices: np.ndarray
    faces: np.ndarray
    rgba: tuple[float, ...] | None


def load_parts(file: Path) -> tuple[Part, ...]:
    """Reads a mesh in m, in the frame that a URDF refers to.

    Units of a COLLADA file count, its up axis does not, as in RViz: files that say `Y_UP` are in
    use with z up. Of a texture the mean colour is read.

    Returns:
        One part for each colour; none if the file cannot be read.
    """
    status = file.stat()
    return _load(file, status.st_size, status.st_mtime_ns)


@lru_cache(MOST_MESHES)
def _load(file: Path, size: int, changed: int) -> tuple[Part, ...]:
    """Reads a mesh, once as long as its size and time of change stay."""
    import trimesh

    if size > 10 * MAX_BYTES:
        return ()
    try:
        scene = trimesh.load_scene(file, process=False)
        if scene.units and scene.units != "meters":
            scene = scene.convert_units("meters")
        meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception:  # The exceptions of the formats' libraries are not documented.
        return ()
    by_color: dict[tuple[float, ...] | None, list[trimesh.Trimesh]] = {}
    for mesh in meshes:
        if len(mesh.faces):
            by_color.setdefault(_color(mesh), []).append(mesh)
    turn = Z_UP if file.suffix.lower() in Y_UP else np.eye(3)
    parts = []
    for rgba, same in sorted(by_color.items(), key=lambda part: part[0] or ()):
        whole = trimesh.util.concatenate(same)
        parts.append(Part(np.asarray(whole.vertices) @ turn.T, np.asarray(whole.faces), rgba))
    return tuple(parts)


def bounds(file: Path) -> np.ndarray:
    """Returns the corners (2, 3) m of a mesh's bounding box; empty (0, 3) without a mesh."""
    parts = load_parts(file)
    if not parts:
        return np.empty((0, 3))
    points = np.concatenate([part.vertices[np.unique(part.faces)] for part in parts])
    return np.array([points.min(axis=0), points.max(axis=0)])


def write_meshes(arm: ArmTree, folder: Path) -> Converted:
    """Writes the visual meshes of an arm, if it has any, into a folder, in their final size.

    A mesh with several colours becomes several files. The meshes of the result are named relative
    to the folder's parent, where the URDF belongs.

    Raises:
        OSError: if a file cannot be written.
    """
    writer = _MeshWriter(folder)
    links = tuple(writer.write(link) for link in arm.links)
    changes = []
    if writer.endings:
        size = sum(file.stat().st_size for file in folder.iterdir())
        unit = f"{size / 1e6:.1f} MB" if size > 1e6 else f"{size / 1e3:.0f} kB"
        endings = ", ".join(sorted(writer.endings))
        changes.append(f"meshes ({endings}) become .obj files, one for each colour: {unit} in all")
    if writer.coarse:
        text = f"vertices up to {10.0 ** -DIGITS[-1]:g} m apart are merged in meshes with more than"
        changes.append(f"{text} {MOST_FACES} faces: {listed(writer.coarse)}")
    if writer.unreadable:
        changes.append(f"meshes that cannot be read are left out: {listed(writer.unreadable)}")
    return Converted(replace(arm, links=links), tuple(changes))


class _MeshWriter:
    """Writer of meshes, each once for a size.

    Attributes:
        endings: Endings of the files of meshes that were read, in lower case.
        coarse: Names of files with too many faces.
        unreadable: Names of files that cannot be read.
    """

    def __init__(self, folder: Path):
        self._folder = folder
        self._written: dict[tuple[Path, tuple[float, ...]], list[tuple[Path, Part]]] = {}
        self._taken: set[str] = set()
        self.endings = set[str]()
        self.coarse, self.unreadable = dict[str, None](), dict[str, None]()

    def write(self, link: ArmLink) -> ArmLink:
        """Writes the meshes of a link, and returns it with them."""
        visuals = [part for visual in link.visuals for part in self._parts(visual)]
        return replace(link, visuals=tuple(visuals))

    def _parts(self, visual: Geometry) -> Iterator[Geometry]:
        if visual.file is None:
            yield visual
            return
        key = visual.file, visual.numbers
        if key not in self._written:
            self._written[key] = [
                (self._write(visual.file, part, visual.numbers), part)
                for part in load_parts(visual.file)
            ]
        if self._written[key]:
            self.endings.add(visual.file.suffix.lower())
        else:
            self.unreadable[visual.file.name] = None
        for path, part in self._written[key]:
            rgba = part.rgba or visual.rgba or GREY
            yield replace(visual, numbers=(1.0, 1.0, 1.0), file=path, rgba=rgba)

    def _write(self, file: Path, part: Part, scale: tuple[float, ...]) -> Path:
        """Writes a part in its size, and returns its path relative to the folder's parent."""
        import trimesh

        stem, number = UNREADABLE.sub("_", file.stem), 1
        name = f"{stem}.obj"
        while name.lower() in self._taken:
            number += 1
            name = f"{stem}_{number}.obj"
        self._taken.add(name.lower())  # Some systems do not tell capitals apart.
        # A mirrored mesh would be inside out.
        faces = part.faces[:, ::-1] if np.prod(scale) < 0 else part.faces
        mesh = trimesh.Trimesh(part.vertices, faces, process=False)
        for digits in DIGITS:
            merged = mesh.copy()
            merged.merge_vertices(digits_vertex=digits)
            merged.update_faces(merged.nondegenerate_faces())
            if not len(merged.faces):  # The mesh is smaller than that.
                break
            mesh = merged
            if digits < DIGITS[0]:
                self.coarse[file.name] = None
            if len(mesh.faces) <= MOST_FACES:
                break
        mesh.vertices = mesh.vertices * scale
        mesh.remove_unreferenced_vertices()
        text = _wavefront(mesh)
        self._folder.mkdir(parents=True, exist_ok=True)
        (self._folder / name).write_text(text)
        return Path(self._folder.name) / name


def _wavefront(mesh: "trimesh.Trimesh") -> str:
    """Returns a Wavefront file with the normal of each face, which Drake's renderers require."""
    normals, index = np.unique(mesh.face_normals.round(3) + 0.0, axis=0, return_inverse=True)
    digits = DIGITS[0]
    lines = [
        f"v {x:.{digits}f} {y:.{digits}f} {z:.{digits}f}" for x, y, z in mesh.vertices.tolist()
    ]
    lines += [f"vn {x:.3g} {y:.3g} {z:.3g}" for x, y, z in normals.tolist()]
    faces = zip((mesh.faces + 1).tolist(), (index.ravel() + 1).tolist(), strict=True)
    lines += [f"f {a}//{n} {b}//{n} {c}//{n}" for (a, b, c), n in faces]
    return "\n".join([*lines, ""])


def _color(mesh: "trimesh.Trimesh") -> tuple[float, ...] | None:
    """Returns the colour of a mesh as fractions, that of a texture averaged; None without one."""
    if not mesh.visual.defined:
        return None
    material = getattr(mesh.visual, "material", None)
    textures = (getattr(material, name, None) for name in ("image", "baseColorTexture"))
    if (image := next((image for image in textures if image is not None), None)) is not None:
        rgba = np.append(np.asarray(image.convert("RGB")).reshape(-1, 3).mean(axis=0), 255)
    else:
        rgba = mesh.visual.main_color if material is None else material.main_color
    return tuple((np.asarray(rgba)[:4] / 255).round(3).tolist())

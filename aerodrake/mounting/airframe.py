"""URDF of a multirotor's base: body, rotors and legs, in the looks of the packaged vehicle."""

import math
from collections.abc import Iterator

import numpy as np

from aerodrake.model.vehicle.robot import BASE_FRAME
from aerodrake.mounting.sizing import PACKAGED_DISC_M, Multirotor

MESHES = "package://aerodrake/robots/meshes"
COLORS = {
    "shell": "0.90 0.90 0.88 1",
    "charcoal": "0.23 0.24 0.26 1",
    "carbon": "0.13 0.135 0.15 1",
    "steel": "0.56 0.58 0.61 1",
    "orange": "0.96 0.42 0.07 1",
    "disc": "0.45 0.48 0.52 0.16",
}
"""Colours of the base by the name of their material, which has a prefix in the URDF."""
PREFIX = "multirotor_"
"""Prefix of the names of the base's materials, so that they differ from the arm's."""
LEGS = 4
BODY = 0.24, 0.27, 0.09
"""Size of the packaged vehicle's body, in m."""
MOUNT_DEPTH = 0.06
"""Depth in m of the plate below the packaged vehicle's body that carries the arm."""
SPINS = "ccw", "cw"


def base_urdf(multirotor: Multirotor) -> str:
    """Returns the elements of a URDF for the base, its materials and the frames of its rotors."""
    ixx, iyy, izz = multirotor.inertia
    parts = [
        "<!-- Base: the multirotor. Its sizes are in proportion to aerodrake's own. -->",
        *(
            f'<material name="{PREFIX}{name}"><color rgba="{rgba}"/></material>'
            for name, rgba in COLORS.items()
        ),
        f'<link name="{BASE_FRAME}">',
        "  <inertial>",
        f'    <mass value="{multirotor.mass:g}"/>',
        f'    <inertia ixx="{ixx:.4g}" iyy="{iyy:.4g}" izz="{izz:.4g}" ixy="0" ixz="0" iyz="0"/>',
        "  </inertial>",
        *(f"  {line}" for line in (*_body(multirotor), *_rotors(multirotor), *_legs(multirotor))),
        "</link>",
        "<!-- Rotors: thrust along z; named by the direction of rotation seen from above. -->",
        *_frames(multirotor),
    ]
    return "".join(f"  {part}\n" for part in parts)


def rotor_positions(multirotor: Multirotor) -> np.ndarray:
    """Returns the positions (rotors, 3) m of the rotors in the base's frame."""
    angles = multirotor.angles
    height = np.full(len(angles), multirotor.rotor_height)
    return np.column_stack(
        [multirotor.radius * np.cos(angles), multirotor.radius * np.sin(angles), height]
    )


def feet_positions(multirotor: Multirotor) -> np.ndarray:
    """Returns the centres (4, 3) m of the spherical feet in the base's frame."""
    angles = np.pi / 4 + np.pi / 2 * np.arange(LEGS)
    across = _foot_distance(multirotor)
    depth = np.full(LEGS, foot_radius(multirotor) - multirotor.feet)
    return np.column_stack([across * np.cos(angles), across * np.sin(angles), depth])


def foot_radius(multirotor: Multirotor) -> float:
    """Returns the radius of a foot in m."""
    return 0.02 * multirotor.scale


def _foot_distance(multirotor: Multirotor) -> float:
    """Returns the distance of the feet from the base's z axis in m."""
    return 0.72 * multirotor.radius


def _visual(shape: str, color: str, xyz: object = (0, 0, 0), rpy: object = (0, 0, 0)) -> str:
    return (
        f'<visual><origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>'
        f'<geometry>{shape}</geometry><material name="{PREFIX}{color}"/></visual>'
    )


def _collision(shape: str, xyz: object) -> str:
    return f'<collision><origin xyz="{_text(xyz)}"/><geometry>{shape}</geometry></collision>'


def _text(numbers: object) -> str:
    return " ".join(f"{number:.5g}" for number in np.asarray(numbers, dtype=float) + 0.0)


def _mesh(name: str, scale: float) -> str:
    return f'<mesh filename="{MESHES}/{name}.obj" scale="{_text([scale] * 3)}"/>'


def _cylinder(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius:.5g}" length="{length:.5g}"/>'


def _body(multirotor: Multirotor) -> Iterator[str]:
    scale = multirotor.scale
    for name, color in zip(
        ("canopy", "tray", "seam", "stripe"), ("shell", "charcoal", "orange", "orange"), strict=True
    ):
        yield _visual(_mesh(name, scale), color)
    yield _visual(_cylinder(0.046 * scale, 0.022 * scale), "charcoal", (0, 0, -0.045 * scale))
    yield _visual(
        _cylinder(0.043 * scale, 0.004 * scale), "steel", (0, 0, (0.002 - MOUNT_DEPTH) * scale)
    )
    size = _text([length * scale for length in BODY])
    yield _collision(f'<box size="{size}"/>', (0, 0, 0.01 * scale))


def _rotors(multirotor: Multirotor) -> Iterator[str]:
    size = multirotor.disc / PACKAGED_DISC_M
    length = multirotor.radius
    for i, (angle, place) in enumerate(
        zip(multirotor.angles, rotor_positions(multirotor), strict=True)
    ):
        middle = length / 2 * np.array([math.cos(angle), math.sin(angle), 0])
        tube = _cylinder(0.0125 * multirotor.scale, length)
        yield _visual(tube, "carbon", middle, (0, math.pi / 2, angle))
        post = multirotor.rotor_height + 0.0125 * multirotor.scale
        below = place - [0, 0, post / 2]
        yield _visual(_cylinder(0.014 * multirotor.scale, post), "charcoal", below)
        yield _visual(_mesh("motor", size), "charcoal", place)
        color = "orange" if math.sin(angle) > 0.1 else "shell"  # The front is along y.
        yield _visual(_cylinder(0.0288 * size, 0.005 * size), color, place - [0, 0, 0.028 * size])
        propeller = _mesh(f"propeller_{SPINS[i % 2]}", size)
        yield _visual(propeller, "carbon", place, (0, 0, angle + 0.5))
        yield _visual(_cylinder(multirotor.disc, 0.002 * size), "disc", place)


def _legs(multirotor: Multirotor) -> Iterator[str]:
    """Yields the legs, which lean outward, with spheres as feet."""
    scale, foot = multirotor.scale, foot_radius(multirotor)
    for place in feet_positions(multirotor):
        outward = place[:2] / np.linalg.norm(place[:2])
        top = np.append(0.6 * place[:2], 0)
        direction = place - top
        lean = math.atan2(float(direction[:2] @ outward), -float(direction[2]))
        tube = _cylinder(0.008 * scale, float(np.linalg.norm(direction)))
        rpy = (0, -lean, math.atan2(outward[1], outward[0]))
        yield _visual(tube, "carbon", (top + place) / 2, rpy)
        strut = np.append(top[:2] / 2, 0)
        turn = (0, math.pi / 2, math.atan2(outward[1], outward[0]))
        yield _visual(_cylinder(0.01 * scale, float(np.linalg.norm(top))), "carbon", strut, turn)
        sphere = f'<sphere radius="{foot:.5g}"/>'
        yield _visual(sphere, "charcoal", place)
        yield _collision(sphere, place)


def _frames(multirotor: Multirotor) -> Iterator[str]:
    for i, place in enumerate(rotor_positions(multirotor)):
        name = f"rotor_{i + 1}_{SPINS[i % 2]}"
        yield f'<frame name="{name}" link="{BASE_FRAME}" xyz="{_text(place)}" rpy="0 0 0"/>'

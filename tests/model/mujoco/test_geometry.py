"""Contacts of MuJoCo against those of Drake: with the ground, and between links."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from aerodrake.model.mujoco.model import body_numbers
from aerodrake.model.vehicle.state import VehicleState
from tests.mujoco_vehicles import BothEngines
from tests.urdfs import HEXAROTOR, with_urdf

CYLINDER = '<geometry><cylinder radius="0.01" length="0.08"/></geometry></collision>'
BALL = '<geometry><sphere radius="0.15"/></geometry></collision>'
"""Collision geometry of the hand, and another one of it."""
LINKS = HEXAROTOR[: HEXAROTOR.index("<drake:collision_filter_group")]
PYRAMID = "v 0.1 0.1 0\nv -0.1 0.1 0\nv 0 -0.1 0\nv 0 0 0.15\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
PLATE = "v 0.1 0.1 0\nv -0.1 0.1 0\nv -0.1 -0.1 0\nv 0.1 -0.1 0\nf 1 2 3\nf 1 3 4\n"
SHAPES = {
    "box": '<box size="0.2 0.1 0.05"/>',
    "cylinder": '<cylinder radius="0.06" length="0.16"/>',
    "capsule": '<capsule radius="0.06" length="0.16"/>',
    "ellipsoid": '<drake:ellipsoid a="0.1" b="0.06" c="0.03"/>',
    "pyramid": '<mesh filename="pyramid.obj" scale="1 2 0.5"/>',
    "plate": '<mesh filename="plate.obj"/>',
}
"""Shapes of the base, instead of its own geometry."""


def with_shape(shape: str, folder: Path) -> BothEngines:
    """Returns the hexarotor with a shape, turned and moved, as the base's only geometry."""
    (folder / "pyramid.obj").write_text(PYRAMID)
    (folder / "plate.obj").write_text(PLATE)
    head, tail = HEXAROTOR.split("<collision>", 1)
    geometry = f'<origin xyz="0.02 0.03 -0.3" rpy="0.2 0.5 -0.4"/><geometry>{shape}</geometry>'
    text = head + f"<collision>{geometry}</collision></link>" + tail.split("</link>", 1)[1]
    return BothEngines.make(with_urdf(text, folder, base_position_m=(0.0, 0.0, 2.0)))


def depths(both: BothEngines, x: np.ndarray) -> tuple[float, float]:
    """Returns the deepest penetration in m of Drake and of MuJoCo at a state."""
    pairs = both.penetrations(x)
    zeros = [np.zeros(size) for size in (both.engine.model.nu, both.vehicle.joints)]
    both.engine.write(x, *zeros, np.zeros(6 + both.vehicle.joints))
    mujoco.mj_forward(both.engine.model, both.engine.data)
    contacts = both.engine.data.contact.dist
    return max((p.depth for p in pairs), default=0.0), -min(contacts, default=0.0)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_penetrate_the_ground_as_deep_as_in_drake(name, tmp_path):
    both, rng = with_shape(SHAPES[name], tmp_path), np.random.default_rng(0)
    seen = 0.0
    for _ in range(20):
        rpy = tuple(rng.uniform(-0.5, 0.5, 3))
        x = VehicleState.at_rest([0.1, 0.2, rng.uniform(0.25, 0.35)], both.vehicle.working, rpy)
        drake, theirs = depths(both, x.to_vector())
        assert theirs == pytest.approx(drake, abs=1e-5)
        seen = max(seen, drake)
    assert seen > 0.01


def contacts(both: BothEngines) -> set[frozenset[int]]:
    """Returns the pairs of bodies, by Drake's indices, that touch in MuJoCo's last results."""
    model, numbers = both.engine.model, body_numbers(both.engine.model, both.plant)
    bodies = model.geom_bodyid[both.engine.data.contact.geom]
    return {frozenset(numbers.index(body) for body in pair) for pair in bodies}


def test_links_collide_with_each_other_unless_they_are_filtered(tmp_path):
    """Without the group of links, those that a joint connects still do not collide."""
    unfiltered = LINKS.replace(CYLINDER, BALL) + "</robot>"
    both = BothEngines.make(with_urdf(unfiltered, tmp_path))
    rng, pairs = np.random.default_rng(0), set()
    for _ in range(20):
        x = both.random_state(rng)
        drake, theirs = depths(both, x)
        expected = {
            frozenset(both.body_index(geometry) for geometry in (p.id_A, p.id_B))
            for p in both.penetrations(x)
        }
        assert contacts(both) == expected
        assert theirs == pytest.approx(drake, abs=1e-4)
        pairs |= expected
    assert len(pairs) > 2
    filtered = BothEngines.make(with_urdf(HEXAROTOR.replace(CYLINDER, BALL), tmp_path))
    depths(filtered, x)
    assert expected and not contacts(filtered)


def test_friction_of_two_materials(tmp_path):
    """Drake's law of combination, 2 a b / (a + b), of the dynamic coefficients; 0.6 of the ground,
    and 1 of links by default."""
    friction = '<drake:mu_static value="0.9"/><drake:mu_dynamic value="0.4"/>'
    head, tail = HEXAROTOR.rsplit("</collision>", 1)
    properties = f"<drake:proximity_properties>{friction}</drake:proximity_properties>"
    both = BothEngines.make(with_urdf(f"{head}{properties}</collision>{tail}", tmp_path))
    model = both.engine.model
    assert model.npair == 8
    assert sorted(model.pair_friction[:, 0])[0] == pytest.approx(2 * 0.4 * 0.6 / 1.0)
    np.testing.assert_allclose(sorted(model.pair_friction[:, 0])[1:], 2 * 0.6 / 1.6)
    np.testing.assert_array_equal(model.pair_friction[:, 0], model.pair_friction[:, 1])

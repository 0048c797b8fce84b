"""Collision geometry that overlaps at the start is refused, with the names of the links."""

import numpy as np
import pytest

from aerodrake.model.vehicle.overlap import deepest_overlap
from aerodrake.model.vehicle.robot import RobotDescription, make_nominal_plant
from aerodrake.model.vehicle.vehicle import VehicleModel
from tests.urdfs import HEXAROTOR, changed, vehicle_refusal, with_urdf

UNFILTERED = HEXAROTOR[: HEXAROTOR.index("<drake:collision_filter_group")] + "</robot>"
CYLINDER = '<geometry><cylinder radius="0.01" length="0.08"/></geometry></collision>'


def with_ball(radius: float, filtered: bool = False) -> str:
    """Returns the hexarotor with a sphere, in m, as collision geometry of its hand."""
    ball = f'<geometry><sphere radius="{radius}"/></geometry></collision>'
    return changed(HEXAROTOR if filtered else UNFILTERED, CYLINDER, ball)


def test_links_that_do_not_overlap(tmp_path):
    VehicleModel.load(with_urdf(UNFILTERED, tmp_path))


def test_the_depth_is_that_of_two_spheres(tmp_path):
    """The hand's sphere and one of the feet, at a distance that kinematics gives."""
    path = tmp_path / "robot.urdf"
    path.write_text(with_ball(0.25))
    plant, scene_graph = make_nominal_plant(RobotDescription.read(str(path)))
    q = plant.GetDefaultPositions()
    q[7:] = [0.0, -0.2, 1.7, -1.0]
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    hand, base = (plant.GetFrameByName(name) for name in ("hand", "base"))
    centre = plant.CalcPointsPositions(context, hand, [0, 0, -0.04], base)[:, 0]
    feet = np.array([[0.1732, 0.1, -0.34], [-0.1732, 0.1, -0.34], [0, -0.2, -0.34]])
    spheres = 0.25 + 0.015 - np.linalg.norm(feet - centre, axis=1)
    overlap = deepest_overlap(plant, scene_graph, q)
    assert set(overlap.links) <= {"hand", "base", "upper_arm", "shoulder"}
    assert overlap.depth >= spheres.max() > 0


def test_overlap_is_refused_with_both_links(tmp_path):
    message = vehicle_refusal(with_ball(0.25), tmp_path)
    assert message.startswith("vehicle.working_rad: expected angles at which the links do not")
    assert "hand" in message and " mm deep in " in message and "collision_filter_group" in message


def test_filtered_links_and_neighbours_may_overlap(tmp_path):
    VehicleModel.load(with_urdf(with_ball(0.25, filtered=True), tmp_path))
    VehicleModel.load(with_urdf(with_ball(0.05), tmp_path))


@pytest.mark.parametrize("height", [-1.0, 0.3])
def test_vehicles_in_the_ground_are_refused(height, tmp_path):
    position = (0.0, 0.0, height)
    message = vehicle_refusal(HEXAROTOR, tmp_path, base_position_m=position)
    assert message.startswith("vehicle.base_position_m[2]: expected 0.355 m or more, so that feet")


def test_an_arm_without_inertia_is_refused_by_its_joint(tmp_path):
    """The hand has no mass, and its motor no inertia."""
    start = HEXAROTOR.index("<inertial>", HEXAROTOR.index('<link name="hand">'))
    end = HEXAROTOR.index("</inertial>", start) + len("</inertial>")
    text = HEXAROTOR[:start] + HEXAROTOR[end:]
    text = changed(text, 'rotor_inertia value="6e-7"', 'rotor_inertia value="0"')
    message = vehicle_refusal(text, tmp_path)
    assert "robot.urdf: " in message and "wrist_pitch" in message

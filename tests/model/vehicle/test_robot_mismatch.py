"""Model mismatch: it changes masses and inertias of links, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from aerodrake.model.vehicle.robot import RobotDescription, add_visible_robot
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mismatch
from aerodrake.support.errors import BadInput
from aerodrake.support.files import locate
from tests.robots import at, make_plant
from tests.trim import assert_same_vehicle

MASS, INERTIA = 1.3, 0.8
OFF = Mismatch(mass_scale=MASS, inertia_scale=INERTIA)


@pytest.fixture(scope="module")
def exact(vehicle, scene_graph):
    return make_plant(vehicle.robot, scene_graph, Mismatch())


@pytest.fixture(scope="module")
def off(vehicle, scene_graph):
    return make_plant(vehicle.robot, scene_graph, OFF)


def links(plant):
    robot = plant.GetBodyByName("base").model_instance()
    return [plant.get_body(index) for index in plant.GetBodyIndices(robot)]


def visuals(plant) -> list[int]:
    """Returns the number of visual geometries of each link."""
    return [len(plant.GetVisualGeometriesForBody(body)) for body in links(plant)]


def visible(robot: str, scene_graph: SceneGraph) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_visible_robot(plant, RobotDescription.read(robot))
    plant.Finalize()
    return plant


def about_centre(body) -> np.ndarray:
    """Returns the inertia (3, 3) kg m^2 of a link about its centre of mass."""
    inertia = body.default_spatial_inertia()
    return inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()


def test_every_link_has_mass_and_inertia_scaled(exact, off):
    pairs = list(zip(links(exact), links(off), strict=True))
    assert len(pairs) == 1 + 6  # The base, and one for each joint.
    for link, scaled in pairs:
        assert scaled.name() == link.name()
        assert scaled.default_mass() == pytest.approx(MASS * link.default_mass())
        np.testing.assert_allclose(scaled.default_com(), link.default_com(), atol=1e-15)
        np.testing.assert_allclose(
            about_centre(scaled), INERTIA * about_centre(link), rtol=1e-9, atol=1e-16
        )


def test_total_mass_and_weight(exact, off, bent_state):
    total = [plant.CalcTotalMass(at(plant, bent_state)) for plant in (exact, off)]
    np.testing.assert_allclose(total, [3.8, MASS * 3.8])
    weight = [plant.CalcGravityGeneralizedForces(at(plant, bent_state)) for plant in (exact, off)]
    np.testing.assert_allclose(weight[1], MASS * weight[0], rtol=1e-12, atol=1e-14)


def test_composite_inertia_is_that_of_the_links_by_the_parallel_axis_theorem(
    exact, off, bent_state
):
    context, composite = at(exact, bent_state), np.zeros((3, 3))
    masses = MASS * np.array([body.default_mass() for body in links(exact)])
    poses = [body.EvalPoseInWorld(context) for body in links(exact)]
    places = np.array(
        [pose @ body.default_com() for pose, body in zip(poses, links(exact), strict=True)]
    )
    arms = places - masses @ places / masses.sum()
    for body, pose, mass, r in zip(links(exact), poses, masses, arms, strict=True):
        R = pose.rotation().matrix()
        turned = R @ (INERTIA * about_centre(body)) @ R.T
        composite += turned + mass * (r @ r * np.eye(3) - np.outer(r, r))

    there = at(off, bent_state)
    inertia = off.CalcSpatialInertia(
        there, off.world_frame(), [body.index() for body in links(off)]
    )
    central = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    np.testing.assert_allclose(central, composite, rtol=1e-9, atol=1e-12)


def test_the_mass_matrix_changes_by_the_links_alone(exact, off, bent_state):
    """The reflected inertia of the motors is not scaled."""
    context, world = at(exact, bent_state), exact.world_frame()
    expected = np.zeros((exact.num_velocities(),) * 2)
    for body in links(exact):
        J = exact.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, body.body_frame(), body.default_com(), world, world
        )
        J_w, J_v = np.split(J, 2)
        R = body.EvalPoseInWorld(context).rotation().matrix()
        expected += (MASS - 1) * body.default_mass() * J_v.T @ J_v
        expected += (INERTIA - 1) * J_w.T @ R @ about_centre(body) @ R.T @ J_w
    added = off.CalcMassMatrix(at(off, bent_state)) - exact.CalcMassMatrix(context)
    np.testing.assert_allclose(added, expected, atol=1e-12)


@pytest.mark.parametrize("key", ["mass_scale", "inertia_scale"])
def test_mass_alone_and_inertia_alone(vehicle, scene_graph, exact, key):
    plant = make_plant(vehicle.robot, scene_graph, Mismatch(**{key: 2.0}))
    scales = np.array([1.0 + (key == "mass_scale"), 1.0 + (key == "inertia_scale")])
    for link, scaled in zip(links(exact), links(plant), strict=True):
        moments = [np.trace(about_centre(body)) for body in (link, scaled)]
        masses = [body.default_mass() for body in (link, scaled)]
        np.testing.assert_allclose(
            [masses[1], moments[1]], scales * [masses[0], moments[0]], rtol=1e-9
        )


def test_everything_else_is_unchanged(exact, off):
    assert off.GetStateNames() == exact.GetStateNames()
    assert off.GetActuatorNames() == exact.GetActuatorNames()
    assert off.num_collision_geometries() == exact.num_collision_geometries()
    for limits in (
        "GetPositionLowerLimits",
        "GetPositionUpperLimits",
        "GetVelocityUpperLimits",
        "GetAccelerationUpperLimits",
        "GetEffortUpperLimits",
    ):
        np.testing.assert_array_equal(getattr(off, limits)(), getattr(exact, limits)())


def test_meshes_beside_a_robot_elsewhere_are_loaded(vehicle, tmp_path, scene_graph, exact):
    text = locate(vehicle.robot).read_text().replace("package://aerodrake/robots/", "")
    folder = tmp_path / "my 50% robot"
    folder.mkdir()
    (folder / "own.urdf").write_text(text)
    (folder / "meshes").symlink_to(locate(vehicle.robot).parent / "meshes")
    drawn = [visible(robot, scene_graph) for robot in (str(folder / "own.urdf"), vehicle.robot)]
    assert visuals(drawn[0]) == visuals(drawn[1])
    assert sum(visuals(drawn[0])) > 10 and not any(visuals(exact))


def test_an_undeclared_prefix_is_kept(vehicle, tmp_path):
    """Drake accepts it."""
    text = locate(vehicle.robot).read_text().replace(' xmlns:drake="https://drake.mit.edu"', "")
    (tmp_path / "own.urdf").write_text(text)
    robot = RobotDescription.read(str(tmp_path / "own.urdf"))
    scaled = robot.invisible_urdf(OFF)
    assert "xmlns" not in scaled
    assert scaled.count("drake:acceleration") == text.count("drake:acceleration") > 0


def test_scaling_leaves_the_description_unchanged(vehicle):
    robot = vehicle.description
    before = robot.document.toxml()
    assert robot.invisible_urdf(OFF) != robot.invisible_urdf(Mismatch())
    assert robot.document.toxml() == before


def test_the_vehicle_model_has_no_mismatch(scenario, vehicle):
    loaded = VehicleModel.load(replace(scenario, mismatch=OFF))
    assert_same_vehicle(loaded, vehicle)


def test_the_centre_of_mass_of_the_base_is_moved_and_nothing_else(vehicle, scene_graph, exact):
    moved = Mismatch(centre_of_mass_m=(0.005, -0.01, 0.02))
    plant = make_plant(vehicle.robot, scene_graph, moved)
    for link, other in zip(links(exact), links(plant), strict=True):
        offset = moved.centre_of_mass_m if link.name() == "base" else np.zeros(3)
        np.testing.assert_allclose(other.default_com() - link.default_com(), offset, atol=1e-15)
        np.testing.assert_allclose(about_centre(other), about_centre(link), atol=1e-12)
        assert other.default_mass() == link.default_mass()


def test_a_base_without_mass_has_no_centre_to_move(vehicle, tmp_path):
    document = RobotDescription.read(vehicle.robot).document
    base = document.documentElement.getElementsByTagName("link")[0]
    assert base.getAttribute("name") == "base"
    base.removeChild(base.getElementsByTagName("inertial")[0])
    robot = RobotDescription("own.urdf", document)
    with pytest.raises(BadInput, match="link base: expected a mass"):
        robot.invisible_urdf(Mismatch(centre_of_mass_m=(0.01, 0.0, 0.0)))

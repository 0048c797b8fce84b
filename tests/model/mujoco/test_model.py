"""Mass, inertia, kinematics and dynamics of MuJoCo's model are those of Drake's plant."""

import mujoco
import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex

from aerodrake.model.mujoco.model import body_numbers
from aerodrake.scenario import Mismatch
from tests.mujoco_vehicles import BothEngines, from_mujoco
from tests.robots import at

STATES = 20


def states(both: BothEngines) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    return [both.random_state(rng) for _ in range(STATES)]


def forward(both: BothEngines, x: np.ndarray) -> None:
    """Computes all of MuJoCo's intermediate results at a state without forces."""
    n, k = both.vehicle.joints, both.engine.model.nu
    both.engine.write(x, np.zeros(k), np.zeros(n), np.zeros(6 + n))
    mujoco.mj_forward(both.engine.model, both.engine.data)


def map_of_velocities(both: BothEngines, x: np.ndarray) -> np.ndarray:
    """Returns S (6 + n, 6 + n) with v = S v_mujoco."""
    identity = np.eye(6 + both.vehicle.joints)
    return np.column_stack([from_mujoco(x, column) for column in identity])


def test_mass_and_composite_inertia(both):
    """By the parallel axis theorem from MuJoCo's bodies."""
    plant, model, data = both.plant, both.engine.model, both.engine.data
    bodies = [BodyIndex(i) for i in range(1, plant.num_bodies())]
    for x in states(both)[:5]:
        forward(both, x)
        expected = plant.CalcSpatialInertia(at(plant, x), plant.world_frame(), bodies)
        mass, R = model.body_mass, data.ximat.reshape(-1, 3, 3)
        centre = mass @ data.xipos / mass.sum()
        moments = np.einsum("bij,bj,bkj->ik", R, model.body_inertia, R)
        for m, r in zip(mass, data.xipos - centre, strict=True):
            moments += m * (r @ r * np.eye(3) - np.outer(r, r))
        assert mass.sum() == pytest.approx(expected.get_mass(), rel=1e-12)
        np.testing.assert_allclose(centre, expected.get_com(), atol=1e-12)
        central = expected.Shift(expected.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        np.testing.assert_allclose(moments, central, atol=1e-12)


def test_poses_and_velocities_of_all_bodies(both):
    plant, model, data = both.plant, both.engine.model, both.engine.data
    numbers = body_numbers(model, plant)
    assert sorted(numbers) == list(range(model.nbody))
    for x in states(both):
        context = at(plant, x)
        poses = both.engine.body_poses(x, numbers)
        expected = plant.get_body_poses_output_port().Eval(context)
        for pose, wanted in zip(poses, expected, strict=True):
            assert pose.IsNearlyEqualTo(wanted, 1e-9)
        forward(both, x)
        for number, wanted in zip(
            numbers, plant.get_body_spatial_velocities_output_port().Eval(context), strict=True
        ):
            velocity = np.empty(6)
            mujoco.mj_objectVelocity(
                model, data, mujoco.mjtObj.mjOBJ_XBODY, number, velocity, False
            )
            np.testing.assert_allclose(velocity, wanted.get_coeffs(), atol=1e-9)


def test_mass_matrix_and_bias(both):
    """v = S v_mujoco, and S' v_mujoco = 0 since the base's rate does not turn itself."""
    plant, model, data = both.plant, both.engine.model, both.engine.data
    for x in states(both):
        forward(both, x)
        context, S = at(plant, x), map_of_velocities(both, x)
        M = np.empty((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        np.testing.assert_allclose(M, S.T @ plant.CalcMassMatrix(context) @ S, atol=1e-9)
        bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        np.testing.assert_allclose(data.qfrc_bias, S.T @ bias, atol=1e-9)


def test_accelerations_under_all_forces(both):
    rng = np.random.default_rng(1)
    for x in states(both):
        forces = both.random_forces(rng)
        both.engine.write(x, *forces)
        mujoco.mj_forward(both.engine.model, both.engine.data)
        expected = both.drake_accelerations(x, forces)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(
            from_mujoco(x, both.engine.data.qacc) / scale, expected / scale, atol=1e-9
        )


def test_limits_damping_and_armature(both):
    model, vehicle = both.engine.model, both.vehicle
    joints = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    np.testing.assert_array_equal(model.jnt_range[joints].T, [vehicle.lower, vehicle.upper])
    assert model.jnt_limited[joints].all()
    np.testing.assert_array_equal(model.dof_damping[6:], vehicle.joint_damping)
    armature = [
        both.plant.get_joint_actuator(i).default_reflected_inertia()
        for i in both.plant.GetJointActuatorIndices()
    ]
    np.testing.assert_array_equal(model.dof_armature[6:], armature)
    assert min(armature) > 0 and not model.dof_armature[:6].any()


def test_mujocos_own_reader_of_urdfs_gives_the_same_dynamics(packaged):
    """It reads no reflected inertias and no collision filters, and fixes the base."""
    spec = mujoco.MjSpec.from_string(packaged.vehicle.description.invisible_urdf(Mismatch()))
    spec.compiler.fusestatic = False
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    spec.body("base").add_freejoint()
    model = spec.compile()
    model.dof_armature[:] = packaged.engine.model.dof_armature
    data = mujoco.MjData(model)
    for x in states(packaged)[:5]:
        forward(packaged, x)
        ours = packaged.engine.data
        data.qpos, data.qvel = ours.qpos, ours.qvel
        mujoco.mj_forward(model, data)
        M = [np.empty((model.nv, model.nv)) for _ in range(2)]
        mujoco.mj_fullM(model, data, M[0])
        mujoco.mj_fullM(packaged.engine.model, ours, M[1])
        np.testing.assert_allclose(M[0], M[1], atol=1e-12)
        np.testing.assert_allclose(data.qacc, ours.qacc, rtol=1e-9, atol=1e-9)

"""Inverse dynamics compared with closed forms, Drake's forward dynamics, and power."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import JacobianWrtVariable
from scipy.spatial.transform import Rotation

from aerodrake.model.vehicle.robot import BASE_FRAME, add_robot
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.whole_body import WholeBody, commanded_motion, rigid_body_effort

G = 9.81


@pytest.fixture(scope="module")
def whole_body(vehicle) -> WholeBody:
    return WholeBody(vehicle.plant)


@pytest.fixture(scope="module")
def plant(vehicle) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    return plant


def effort_of(whole_body, state: VehicleState, a_B, qddot) -> tuple[np.ndarray, ...]:
    """Force (3,) and torque (3,) on the base, in the world, and joint torques (n,).

    Without angular acceleration of the base.
    """
    effort = whole_body.effort(state.to_vector(), np.concatenate([np.zeros(3), a_B, qddot]))
    return effort[3:6], effort[:3], effort[6:]


def still(vehicle) -> VehicleState:
    return split_state(vehicle.trim_state.copy())


def moving(vehicle, seed: int, scale: float = 1.0) -> VehicleState:
    """Random state with everything in motion."""
    rng = np.random.default_rng(seed)
    state = split_state(scale * rng.normal(size=len(vehicle.trim_state)))
    state.quaternion[:] = np.roll(Rotation.random(rng=rng).as_quat(), 1)
    state.q[:] = rng.uniform(vehicle.lower, vehicle.upper)
    return state


def centre_of_mass(plant, state: VehicleState) -> np.ndarray:
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state.to_vector())
    return plant.CalcCenterOfMassPositionInWorld(context) - state.p_B


def test_hovering_takes_the_trim(whole_body, vehicle):
    force, torque, joint_torque = effort_of(
        whole_body, still(vehicle), np.zeros(3), np.zeros(vehicle.joints)
    )
    np.testing.assert_allclose(force, [0, 0, vehicle.mass * G], atol=1e-9)
    np.testing.assert_allclose(torque, vehicle.trim_wrench[1:], atol=1e-9)
    np.testing.assert_allclose(joint_torque, vehicle.trim_torque, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_an_arm_at_rest_is_a_point_mass_at_the_centre_of_mass(whole_body, plant, vehicle, seed):
    """At any attitude: m (a + g), and its moment about the base's origin."""
    state = moving(vehicle, seed, scale=0.0)._replace(p_B=np.array([1.0, 2, 3]))
    a_B = np.random.default_rng(seed).normal(size=3)
    force, torque, _ = effort_of(whole_body, state, a_B, np.zeros(vehicle.joints))
    np.testing.assert_allclose(force, vehicle.mass * (a_B + [0, 0, G]), atol=1e-9)
    np.testing.assert_allclose(torque, np.cross(centre_of_mass(plant, state), force), atol=1e-9)
    assert np.linalg.norm(torque) > 0.1


@pytest.mark.parametrize("seed", range(3))
def test_force_is_the_change_of_momentum_and_gravity(whole_body, plant, vehicle, seed):
    """Of the arm in motion under a base that does not turn, by central differences.

    And the torque is that of angular momentum about the base's origin, where that is at rest.
    """
    state, rng = moving(vehicle, seed), np.random.default_rng(seed + 10)
    state.omega_W[:] = state.v_B[:] = 0.0
    qddot = rng.normal(size=vehicle.joints)
    force, torque, _ = effort_of(whole_body, state, np.zeros(3), qddot)

    def momenta(t: float) -> np.ndarray:
        """Returns momentum (6,), angular about the base's origin and linear, in the world."""
        context = plant.CreateDefaultContext()
        at = state._replace(
            q=state.q + t * state.qdot + t**2 / 2 * qddot, qdot=state.qdot + t * qddot
        )
        plant.SetPositionsAndVelocities(context, at.to_vector())
        return plant.CalcSpatialMomentumInWorldAboutPoint(context, state.p_B).get_coeffs()

    h = 1e-5
    angular, linear = np.split((momenta(h) - momenta(-h)) / (2 * h), 2)
    weight = np.array([0, 0, vehicle.mass * G])
    np.testing.assert_allclose(force, linear + weight, rtol=1e-7, atol=1e-6)
    moment = angular + np.cross(centre_of_mass(plant, state), weight)
    np.testing.assert_allclose(torque, moment, rtol=1e-7, atol=1e-6)


def accelerations(plant, state: VehicleState, force, torque_W, joint_torque) -> np.ndarray:
    """Returns v' (6 + n,) by Drake's forward dynamics under the effort of rotors and motors."""
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state.to_vector())
    applied = ExternallyAppliedSpatialForce()
    applied.body_index = plant.GetBodyByName(BASE_FRAME).index()
    applied.p_BoBq_B = np.zeros(3)
    applied.F_Bq_W = SpatialForce(tau=torque_W, f=force)
    plant.get_applied_spatial_force_input_port().FixValue(
        context, Value[list[ExternallyAppliedSpatialForce]]([applied])
    )
    plant.get_actuation_input_port().FixValue(context, joint_torque)
    derivatives = plant.EvalTimeDerivatives(context)
    return derivatives.get_generalized_velocity().CopyToVector()


@pytest.mark.parametrize("seed", range(4))
def test_forward_dynamics_under_the_effort_give_the_accelerations(whole_body, plant, vehicle, seed):
    """Inverse and forward dynamics cancel, also with a rotating base at constant rate."""
    state, rng = moving(vehicle, seed), np.random.default_rng(seed + 20)
    a_B, qddot = rng.normal(size=3), rng.normal(size=vehicle.joints)
    vdot = accelerations(plant, state, *effort_of(whole_body, state, a_B, qddot))
    np.testing.assert_allclose(vdot, [0, 0, 0, *a_B, *qddot], atol=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_acceleration_of_the_centre_of_mass_is_that_of_its_jacobian(
    whole_body, plant, vehicle, seed
):
    state, vdot = moving(vehicle, seed), np.random.default_rng(seed).normal(size=6 + vehicle.joints)
    context, frame = plant.CreateDefaultContext(), plant.world_frame()
    plant.SetPositionsAndVelocities(context, state.to_vector())
    kind = JacobianWrtVariable.kV
    J = plant.CalcJacobianCenterOfMassTranslationalVelocity(context, kind, frame, frame)
    bias = plant.CalcBiasCenterOfMassTranslationalAcceleration(context, kind, frame, frame)
    a_C = whole_body.centre_acceleration(state.to_vector(), vdot)
    np.testing.assert_allclose(a_C, J @ vdot + bias, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_power_of_the_effort_is_that_of_the_energy(whole_body, plant, vehicle, seed):
    """Including the damping of the joints."""
    state, rng = moving(vehicle, seed), np.random.default_rng(seed + 30)
    a_B, qddot = rng.normal(size=3), rng.normal(size=vehicle.joints)
    force, torque, joint_torque = effort_of(whole_body, state, a_B, qddot)

    def energy(t: float) -> float:
        """Returns the energy in J, with the base at a constant rate."""
        context = plant.CreateDefaultContext()
        turned = Rotation.from_rotvec(t * state.omega_W) * Rotation.from_quat(
            np.roll(state.quaternion, -1)
        )
        at = VehicleState(
            np.roll(turned.as_quat(), 1),
            state.p_B + t * state.v_B + t**2 / 2 * a_B,
            state.q + t * state.qdot + t**2 / 2 * qddot,
            state.omega_W,
            state.v_B + t * a_B,
            state.qdot + t * qddot,
        )
        plant.SetPositionsAndVelocities(context, at.to_vector())
        v = plant.GetVelocities(context)
        # The mass matrix includes the reflected inertia of the joints' motors.
        return v @ plant.CalcMassMatrix(context) @ v / 2 + plant.CalcPotentialEnergy(context)

    h = 1e-5
    power = force @ state.v_B + torque @ state.omega_W + joint_torque @ state.qdot
    joints = (plant.get_joint(i) for i in plant.GetJointIndices())
    damping = np.array(
        [
            j.GetDampingVector(plant.CreateDefaultContext())[0]
            for j in joints
            if j.num_velocities() == 1
        ]
    )
    dissipated = damping @ state.qdot**2
    assert power - dissipated == pytest.approx((energy(h) - energy(-h)) / (2 * h), rel=1e-6)


def test_calls_are_independent(whole_body, vehicle):
    first, other = (moving(vehicle, seed) for seed in (0, 1))
    a_B, qddot = np.ones(3), np.ones(vehicle.joints)
    before = effort_of(whole_body, first, a_B, qddot)
    effort_of(whole_body, other, -a_B, qddot)
    again = effort_of(whole_body, first, a_B, qddot)
    np.testing.assert_array_equal(np.concatenate(before), np.concatenate(again))


@pytest.mark.parametrize("seed", range(3))
def test_commanded_motion_combines_the_measured_base_and_the_arm_setpoint(vehicle, seed):
    state, n = moving(vehicle, seed), vehicle.joints
    q_d, qdot_d, qddot_d = np.random.default_rng(seed).normal(size=(3, n))
    x, vdot = commanded_motion(
        state.to_vector(), np.concatenate([q_d, qdot_d, qddot_d]), np.array([1.0, 2.0, 3.0])
    )
    commanded = split_state(x)
    for part in ("quaternion", "p_B", "omega_W", "v_B"):
        np.testing.assert_array_equal(getattr(commanded, part), getattr(state, part))
    np.testing.assert_array_equal(commanded.q, q_d)
    np.testing.assert_array_equal(commanded.qdot, qdot_d)
    np.testing.assert_array_equal(vdot, [0, 0, 0, 1, 2, 3, *qddot_d])


@pytest.mark.parametrize("seed", range(3))
def test_rigid_body_effort_is_the_change_of_momentum_and_weight(vehicle, seed):
    """By differences of R J omega of a body that rotates at a constant rate."""
    state, a_B = moving(vehicle, seed), np.array([1.0, -2.0, 3.0])
    effort = rigid_body_effort(vehicle.mass, vehicle.inertia, state.to_vector(), a_B)
    np.testing.assert_allclose(effort[3:], vehicle.mass * (a_B + [0, 0, G]), rtol=1e-12)

    def angular_momentum(t: float) -> np.ndarray:
        R = Rotation.from_rotvec(t * state.omega_W).as_matrix() @ state.R_B
        return R @ vehicle.inertia @ R.T @ state.omega_W

    h = 1e-5
    rate = (angular_momentum(h) - angular_momentum(-h)) / (2 * h)
    np.testing.assert_allclose(effort[:3], rate, atol=1e-8)

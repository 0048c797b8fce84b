"""Arm controller by itself, and on joints of constant inertia."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Arm
from aerodrake.systems.arm_controller import ArmController

ARM = Arm(bandwidth_rad_s=40.0, damping=0.9, integral_rad_s=5.0)
DT, OFFSET = 0.005, 0.001


@pytest.fixture
def controller(vehicle):
    return ArmController(ARM, vehicle, DT, OFFSET)


class Bench:
    """The controller with joints of constant inertia, which may be blocked."""

    def __init__(self, controller, vehicle):
        self.controller, self.vehicle = controller, vehicle
        self.context = controller.CreateDefaultContext()
        self.q, self.qdot = vehicle.working.copy(), np.zeros(vehicle.joints)

    def tick(self, q_d, qdot_d=None) -> np.ndarray:
        """Returns the torques (n,) N m after an update."""
        n = self.vehicle.joints
        x = self.vehicle.trim_state
        x[7 : 7 + n], x[-n:] = self.q, self.qdot
        qdot_d = np.zeros(n) if qdot_d is None else qdot_d
        setpoint = np.concatenate([q_d, qdot_d, np.zeros(n)])
        self.controller.GetInputPort("state").FixValue(self.context, x)
        self.controller.GetInputPort("joint_setpoint").FixValue(self.context, setpoint)
        self.context.SetDiscreteState(
            self.controller.EvalUniquePeriodicDiscreteUpdate(self.context)
        )
        return self.torque

    @property
    def torque(self) -> np.ndarray:
        return self.controller.GetOutputPort("joint_torque").Eval(self.context)

    @property
    def at_limit(self) -> np.ndarray:
        return self.controller.GetOutputPort("torque_at_limit").Eval(self.context)

    def move(self, torque: np.ndarray) -> None:
        """Moves the joints by one tick under the torques beyond those of trim."""
        M, D = self.vehicle.arm_inertia, np.diag(self.vehicle.joint_damping)
        beyond = torque - self.vehicle.trim_torque - D @ self.qdot
        acceleration = np.linalg.solve(M + D * DT / 2, beyond)
        self.q = self.q + self.qdot * DT + acceleration * DT**2 / 2
        self.qdot = self.qdot + acceleration * DT


@pytest.fixture
def bench(controller, vehicle) -> Bench:
    return Bench(controller, vehicle)


def test_trim_is_an_equilibrium(bench, vehicle):
    np.testing.assert_array_equal(bench.torque, vehicle.trim_torque)
    for _ in range(200):
        np.testing.assert_array_equal(bench.tick(vehicle.working), vehicle.trim_torque)


def test_ports_rate_and_feedthrough(controller, vehicle):
    n = vehicle.joints
    assert controller.GetInputPort("state").size() == VehicleState.size(n)
    assert controller.GetInputPort("joint_setpoint").size() == 3 * n
    assert controller.GetOutputPort("joint_torque").size() == n
    assert not controller.HasAnyDirectFeedthrough()
    timing = controller.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (DT, OFFSET)


def test_torque_is_constant_between_ticks(controller, vehicle):
    simulator = Simulator(controller)
    context = simulator.get_mutable_context()
    port = controller.GetOutputPort("joint_torque")
    setpoint = np.concatenate([vehicle.working, np.zeros(12)])
    controller.GetInputPort("state").FixValue(context, vehicle.trim_state)
    controller.GetInputPort("joint_setpoint").FixValue(context, setpoint)
    simulator.AdvanceTo(0.002)
    controller.GetInputPort("joint_setpoint").FixValue(context, setpoint + 0.01)
    simulator.AdvanceTo(0.0059)
    np.testing.assert_array_equal(port.Eval(context), vehicle.trim_torque)
    simulator.AdvanceTo(0.0061)
    assert np.all(port.Eval(context) > vehicle.trim_torque)


def test_gains_are_per_inertia(bench, vehicle):
    """By hand: M (w^2 e + 2 z w e') and D (e' + w e / (2 z)) beyond trim, and i dt times the part
    of e more at the next tick."""
    e, e_dot = 1e-3 * np.array([1, -2, 3, -1, 2, -3]), 1e-2 * np.array([2, 1, -1, -2, 1, 3])
    expected = vehicle.trim_torque + vehicle.arm_inertia @ (40**2 * e + 2 * 0.9 * 40 * e_dot)
    expected += vehicle.joint_damping * (e_dot + 40 / (2 * 0.9) * e)
    np.testing.assert_allclose(bench.tick(vehicle.working + e, e_dot), expected, rtol=1e-12)
    stiffness = vehicle.arm_inertia * 40**2 + np.diag(vehicle.joint_damping) * 40 / (2 * 0.9)
    expected += 5 * DT * stiffness @ e
    np.testing.assert_allclose(bench.tick(vehicle.working + e, e_dot), expected, rtol=1e-12)


def test_a_constant_load_is_compensated(bench, vehicle):
    load = np.array([0.3, -0.5, 0.2, 0.05, -0.1, 0.1])
    for _ in range(600):
        bench.move(bench.tick(vehicle.working) + load)
    np.testing.assert_allclose(bench.q, vehicle.working, atol=1e-6)
    np.testing.assert_allclose(bench.torque, vehicle.trim_torque - load, atol=1e-5)


def test_blocked_joints_do_not_wind_up(bench, vehicle):
    """After 5 s at the torque limit, the joints stay close to trim and return to it."""
    away = np.where(np.arange(vehicle.joints) % 2, -1.0, 1.0)
    assert not bench.at_limit.any()
    for _ in range(1000):
        torque = bench.tick(vehicle.working + away)
    np.testing.assert_array_equal(torque, away * vehicle.effort)
    assert bench.at_limit.all()

    farthest = np.zeros(vehicle.joints)
    for _ in range(400):
        bench.move(bench.tick(vehicle.working))
        farthest = np.maximum(farthest, np.abs(bench.q - vehicle.working))
    assert np.all(farthest < 0.02)
    np.testing.assert_allclose(bench.q, vehicle.working, atol=1e-5)


def test_torques_are_within_their_limits(bench, vehicle):
    """Joints at their torque limits do not disturb the acceleration of the others."""
    desired = 2 * 0.9 * 40 * vehicle.velocity
    for side in (1, -1):
        wild = bench.tick(vehicle.working + side * 100, np.full(6, side * 100.0))
        assert np.all(np.abs(wild) <= vehicle.effort)
        free = np.abs(wild) < vehicle.effort
        assert 0 < free.sum() < vehicle.joints
        drag = side * vehicle.joint_damping * vehicle.velocity
        driving = wild - drag - vehicle.trim_torque
        acceleration = np.linalg.solve(vehicle.arm_inertia, driving)
        np.testing.assert_allclose(acceleration[free], side * desired[free], rtol=0.05)

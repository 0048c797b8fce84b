"""The rotor monitor on motion that was made by Newton's and Euler's laws, without a plant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.low_level.rotor_lag import advance
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.supervision.rotor_monitor import RotorMonitor, unexplained, watch
from aerodrake.model.vehicle.rotation import rotation_matrix, turned
from aerodrake.model.vehicle.vehicle import GRAVITY, add_robot
from aerodrake.model.vehicle.whole_body import WholeBody
from aerodrake.scenario import Rotor

DT, ROTORS = 0.01, 4
INERTIA = np.diag([0.14, 0.15, 0.2])
R_BC = np.array([0.0, 0.03, -0.06])


@pytest.fixture(scope="module")
def trim(vehicle):
    return allocate(ThrustAllocation.make(vehicle, Rotor()), vehicle.trim_wrench)


@pytest.fixture(scope="module")
def monitor(vehicle, trim) -> RotorMonitor:
    return RotorMonitor.make(vehicle, Rotor(), trim, 0.0, DT)


class Body:
    """A rigid body of the vehicle's mass under rotors, of which shares are missing, and loads."""

    def __init__(self, monitor: RotorMonitor):
        self.monitor = monitor
        self.thrust = monitor.trim.copy()
        self.motion = np.concatenate([np.zeros(6), R_BC, [1.0, 0, 0, 0]])

    def step(self, command, share=1.0, force=(0, 0, 0), at=(0, 0, 0)) -> np.ndarray:
        """(13,) motion one sample later; `force`, N, acts `at`, m, both in the base's frame."""
        monitor = self.monitor
        self.thrust, mean = advance(monitor.lag, self.thrust, np.asarray(command, dtype=float))
        f = mean * share
        lifts = np.outer(f, [0, 0, 1.0])
        torque = np.cross(monitor.p_B - R_BC, lifts).sum(axis=0) + [0, 0, monitor.drag @ f]
        torque += np.cross(np.array(at) - R_BC, force)
        quaternion = self.motion[9:]
        R = rotation_matrix(quaternion)
        omega = np.linalg.solve(INERTIA, R.T @ self.motion[:3])
        # To the second order, as are means over a sample.
        halfway = turned(quaternion, omega * DT / 2)
        R_mid = rotation_matrix(halfway)
        L = self.motion[:3] + DT * R_mid @ torque
        weight = np.array([0, 0, -monitor.mass * GRAVITY])
        P = self.motion[3:6] + DT * (R_mid @ (lifts.sum(axis=0) + force) + weight)
        omega_mid = np.linalg.solve(INERTIA, R_mid.T @ (self.motion[:3] + L) / 2)
        after = turned(quaternion, omega_mid * DT)
        self.motion = np.concatenate([L, P, rotation_matrix(after) @ R_BC, after])
        return self.motion


def follow(monitor, samples: int, fault_at: int = 10**9, seed: int = 0, **loss) -> np.ndarray:
    """(samples, k) shares told, under commands that wander; `loss` from one sample on."""
    body, memory = Body(monitor), monitor.initial_memory()
    rng, told = np.random.default_rng(seed), []
    memory, _ = watch(monitor, memory, monitor.trim, body.motion, True)
    wander = np.zeros(ROTORS)
    for k in range(samples):
        wander += 0.1 * rng.normal(size=ROTORS) - 0.1 * wander
        command = monitor.trim + wander
        body.step(command, **(loss if k >= fault_at else {}))
        memory, shares = watch(monitor, memory, command, body.motion, True)
        told.append(shares)
    return np.array(told)


def share_of(rotor: int, remaining: float) -> np.ndarray:
    share = np.ones(ROTORS)
    share[rotor] = remaining
    return share


def test_motion_that_is_explained_leaves_nothing(monitor):
    body, rng = Body(monitor), np.random.default_rng(1)
    for _ in range(50):
        last, thrust = body.motion, body.thrust
        command = monitor.trim + rng.normal(size=ROTORS)
        _, mean = advance(monitor.lag, thrust, command)
        _, wrench = unexplained(monitor, last, body.step(command), mean)
        np.testing.assert_allclose(wrench, 0, atol=0.02)


@given(st.integers(0, ROTORS - 1), st.floats(0, 1))
def test_what_a_rotor_misses_is_its_row(rotor, remaining):
    monitor = _MONITOR[0]
    body = Body(monitor)
    rows, wrench = unexplained(
        monitor,
        body.motion,
        body.step(monitor.trim, share_of(rotor, remaining)),
        monitor.trim,
    )
    expected = (1 - remaining) * monitor.trim[rotor] * rows[rotor]
    np.testing.assert_allclose(wrench, expected, atol=0.02)


_MONITOR: list[RotorMonitor] = []


@pytest.fixture(autouse=True)
def _shared(monitor):
    """Properties take no fixtures of a smaller scope than a session's."""
    _MONITOR[:] = [monitor]


@pytest.mark.parametrize("rotor", range(ROTORS))
@pytest.mark.parametrize("remaining", [0.0, 0.2, 0.35])
@pytest.mark.parametrize("fault_at", [0, 300])
def test_a_lost_rotor_is_told_at_once(monitor, rotor, remaining, fault_at):
    """From the first sample of a flight on, too; and no other is blamed."""
    told = follow(monitor, fault_at + 40, fault_at, share=share_of(rotor, remaining))
    assert np.all(told[:fault_at] == 1)
    assert np.all(told[fault_at + 15 :, rotor] < 0.4)
    assert np.all(np.delete(told, rotor, axis=1) == 1)


@pytest.mark.parametrize("remaining", [0.0, 0.3])
def test_a_lost_rotor_is_told_within_50_ms(monitor, remaining):
    told = follow(monitor, 320, 300, share=share_of(2, remaining))
    # With 0.3 it is after some more: it must first be seen to be as much.
    assert told[300 + (4 if remaining == 0 else 8), 2] < 0.4


@pytest.mark.parametrize("rotor", range(ROTORS))
def test_a_weak_rotor_is_told_within_a_second(monitor, rotor):
    told = follow(monitor, 700, 300, share=share_of(rotor, 0.8))
    assert np.all(told[400:, rotor] < 0.9) and np.all(told[400:, rotor] > 0.75)
    assert np.all(np.delete(told, rotor, axis=1) == 1)


def test_a_rotor_that_recovers_is_believed(monitor):
    body, memory = Body(monitor), monitor.initial_memory()
    memory, _ = watch(monitor, memory, monitor.trim, body.motion, True)
    for k in range(600):
        body.step(monitor.trim, share_of(1, 0.5) if 200 <= k < 400 else 1.0)
        memory, told = watch(monitor, memory, monitor.trim, body.motion, True)
        if k == 390:
            assert told[1] == pytest.approx(0.5, abs=0.05)
    assert np.all(told > 0.9)


forces = st.tuples(*[st.floats(-30, 30)] * 3)


@settings(max_examples=40)
@given(forces)
def test_a_hand_on_the_base_is_no_rotor(force):
    """Whatever it does, as long as it is at the base's origin."""
    told = follow(_MONITOR[0], 200, 100, force=np.array(force))
    np.testing.assert_array_equal(told, 1)


@settings(max_examples=40)
@given(st.floats(0, 2), st.floats(-0.05, 0.05), st.floats(0.15, 0.25))
def test_a_load_at_the_tool_is_no_rotor(mass, x, y):
    told = follow(_MONITOR[0], 200, 0, force=np.array([0, 0, -mass * GRAVITY]), at=(x, y, -0.3))
    np.testing.assert_array_equal(told, 1)


@settings(max_examples=40)
@given(st.lists(st.floats(0, 0.55), min_size=ROTORS, max_size=ROTORS))
def test_rotors_that_are_weak_together_are_no_lost_rotor(missing):
    told = follow(_MONITOR[0], 120, 60, share=1 - np.array(missing))
    assert np.all(told > 0.4)


def test_samples_that_are_not_believed_teach_nothing(monitor):
    body, memory = Body(monitor), monitor.initial_memory()
    rng = np.random.default_rng(4)
    memory, _ = watch(monitor, memory, monitor.trim, body.motion, True)
    for k in range(300):
        motion, is_believed = body.step(monitor.trim), not 100 <= k < 200
        if not is_believed:
            motion = rng.choice([np.nan, 1e9, -1e9], size=13)
        memory, told = watch(monitor, memory, monitor.trim, motion, is_believed)
        np.testing.assert_array_equal(told, 1)
    body.step(monitor.trim, share_of(3, 0.0))
    for _ in range(10):
        memory, told = watch(
            monitor, memory, monitor.trim, body.step(monitor.trim, share_of(3, 0.0)), True
        )
    assert told[3] < 0.4


@pytest.mark.parametrize("steps", [1, 3])
def test_late_samples_meet_the_thrusts_of_their_time(vehicle, trim, steps):
    """Single rotors are sent up and down: nobody is blamed, unless lateness is not known of."""

    def least(delay_s: float) -> float:
        monitor = RotorMonitor.make(vehicle, Rotor(), trim, delay_s, DT)
        body, memory = Body(monitor), monitor.initial_memory()
        rng, motions, told = np.random.default_rng(5), [body.motion] * (steps + 1), []
        for k in range(400):
            if k % 10 == 0:
                command = trim.copy()
                command[rng.integers(ROTORS)] += rng.uniform(-9, 9)
            motions.append(body.step(command).copy())
            memory, shares = watch(monitor, memory, command, motions[-1 - steps], True)
            told.append(shares.min())
        return min(told)

    assert least(steps * DT) == 1
    assert steps < 3 or least(0.0) < 0.9


def test_momentum_is_that_of_the_links(vehicle):
    """M v of the vehicle, whose first six rows are about the base's origin."""
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.robot)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(6)
    x = vehicle.trim_state + np.concatenate([np.zeros(4), rng.uniform(-0.5, 0.5, 21)])
    plant.SetPositionsAndVelocities(context, x)
    about_base = (plant.CalcMassMatrix(context) @ plant.GetVelocities(context))[:6]
    found = WholeBody(vehicle.robot).momentum(x)
    np.testing.assert_allclose(found[3:6], about_base[3:], atol=1e-12)
    np.testing.assert_allclose(
        found[:3] + np.cross(found[6:], found[3:6]), about_base[:3], atol=1e-12
    )

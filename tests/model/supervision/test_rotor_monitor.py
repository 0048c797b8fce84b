"""Tests of the rotor monitor on a rigid body integrated by the Newton-Euler equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.low_level.rotor_lag import advance
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.supervision.rotor_monitor import (
    NO_SAMPLE,
    MomentumSample,
    RotorMonitor,
    RotorMonitorState,
    residual_wrench,
    update_monitor,
)
from aerodrake.model.vehicle.robot import add_robot
from aerodrake.model.vehicle.rotation import rotation_matrix, turned
from aerodrake.model.vehicle.vehicle import GRAVITY
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
    """Rigid body of the vehicle's mass under rotors of reduced effectiveness and external loads."""

    def __init__(self, monitor: RotorMonitor):
        self.monitor = monitor
        self.thrust = monitor.trim.copy()
        self.sample = MomentumSample(np.zeros(6), R_BC, np.array([1.0, 0, 0, 0]))

    def step(self, command, effectiveness=1.0, force=(0, 0, 0), at=(0, 0, 0)) -> MomentumSample:
        """Returns the next sample; `force`, N, acts `at`, m, both in the base frame."""
        monitor = self.monitor
        self.thrust, mean = advance(monitor.lag, self.thrust, np.asarray(command, dtype=float))
        f = mean * effectiveness
        lifts = np.outer(f, [0, 0, 1.0])
        torque = np.cross(monitor.p_B - R_BC, lifts).sum(axis=0) + [0, 0, monitor.drag @ f]
        torque += np.cross(np.array(at) - R_BC, force)
        (last_L, last_P), quaternion = self.sample.momentum.reshape(2, 3), self.sample.quaternion
        R = rotation_matrix(quaternion)
        omega = np.linalg.solve(INERTIA, R.T @ last_L)
        # Midpoint rule: the thrusts are means over a sample.
        halfway = turned(quaternion, omega * DT / 2)
        R_mid = rotation_matrix(halfway)
        L = last_L + DT * R_mid @ torque
        weight = np.array([0, 0, -monitor.mass * GRAVITY])
        P = last_P + DT * (R_mid @ (lifts.sum(axis=0) + force) + weight)
        omega_mid = np.linalg.solve(INERTIA, R_mid.T @ (last_L + L) / 2)
        after = turned(quaternion, omega_mid * DT)
        self.sample = MomentumSample(np.concatenate([L, P]), rotation_matrix(after) @ R_BC, after)
        return self.sample


class Estimator:
    """Rotor monitor and its state."""

    def __init__(self, monitor: RotorMonitor, first: MomentumSample):
        self.monitor = monitor
        self.state = RotorMonitorState.initial(monitor)
        self.update(monitor.trim, first)

    def update(self, command, sample: MomentumSample) -> np.ndarray:
        """Returns the estimated effectiveness (k,) of the rotors after one more sample."""
        self.state = update_monitor(self.monitor, self.state, command, sample)
        return 1.0 - self.state.loss


def follow(monitor, samples: int, fault_at: int = 10**9, seed: int = 0, **loss) -> np.ndarray:
    """Returns the estimates (samples, k) under random commands, with `loss` from one sample on."""
    body = Body(monitor)
    estimator = Estimator(monitor, body.sample)
    rng, estimates = np.random.default_rng(seed), []
    wander = np.zeros(ROTORS)
    for k in range(samples):
        wander += 0.1 * rng.normal(size=ROTORS) - 0.1 * wander
        command = monitor.trim + wander
        sample = body.step(command, **(loss if k >= fault_at else {}))
        estimates.append(estimator.update(command, sample))
    return np.array(estimates)


def effectiveness_with(rotor: int, remaining: float) -> np.ndarray:
    effectiveness = np.ones(ROTORS)
    effectiveness[rotor] = remaining
    return effectiveness


def test_the_residual_is_zero_without_faults(monitor):
    body, rng = Body(monitor), np.random.default_rng(1)
    for _ in range(50):
        last, thrust = body.sample, body.thrust
        command = monitor.trim + rng.normal(size=ROTORS)
        _, mean = advance(monitor.lag, thrust, command)
        _, residual = residual_wrench(monitor, last, body.step(command), mean, DT)
        np.testing.assert_allclose(residual, 0, atol=0.02)


@given(st.integers(0, ROTORS - 1), st.floats(0, 1))
def test_the_residual_of_a_loss_is_the_fault_signature(rotor, remaining):
    monitor = _MONITOR[0]
    body = Body(monitor)
    signatures, residual = residual_wrench(
        monitor,
        body.sample,
        body.step(monitor.trim, effectiveness_with(rotor, remaining)),
        monitor.trim,
        DT,
    )
    expected = (1 - remaining) * monitor.trim[rotor] * signatures[rotor]
    np.testing.assert_allclose(residual, expected, atol=0.02)


_MONITOR: list[RotorMonitor] = []


@pytest.fixture(autouse=True)
def _shared(monitor):
    """Gives the monitor to hypothesis tests, which take no fixtures of a smaller scope."""
    _MONITOR[:] = [monitor]


@pytest.mark.parametrize("rotor", range(ROTORS))
@pytest.mark.parametrize("remaining", [0.0, 0.2, 0.35])
@pytest.mark.parametrize("fault_at", [0, 300])
def test_a_lost_rotor_is_isolated(monitor, rotor, remaining, fault_at):
    """Also from the first sample of a flight on, and without false alarms for other rotors."""
    estimate = follow(
        monitor, fault_at + 40, fault_at, effectiveness=effectiveness_with(rotor, remaining)
    )
    assert np.all(estimate[:fault_at] == 1)
    assert np.all(estimate[fault_at + 15 :, rotor] < 0.4)
    assert np.all(np.delete(estimate, rotor, axis=1) == 1)


@pytest.mark.parametrize("remaining", [0.0, 0.3])
def test_a_lost_rotor_is_isolated_within_50_ms(monitor, remaining):
    estimate = follow(monitor, 320, 300, effectiveness=effectiveness_with(2, remaining))
    # A partial loss takes longer: its first estimates are smaller.
    assert estimate[300 + (4 if remaining == 0 else 8), 2] < 0.4


@pytest.mark.parametrize("rotor", range(ROTORS))
def test_a_degraded_rotor_is_isolated_within_a_second(monitor, rotor):
    estimate = follow(monitor, 700, 300, effectiveness=effectiveness_with(rotor, 0.8))
    assert np.all(estimate[400:, rotor] < 0.9) and np.all(estimate[400:, rotor] > 0.75)
    assert np.all(np.delete(estimate, rotor, axis=1) == 1)


@pytest.mark.parametrize("rotor", [0, 2])
def test_a_rotor_that_is_weaker_from_the_start_raises_no_alarm_and_hides_no_later_loss(
    monitor, rotor
):
    unequal, later = effectiveness_with(rotor, 0.88), effectiveness_with(rotor, 0.88)
    later[1] = 0.8
    body = Body(monitor)
    estimator = Estimator(monitor, body.sample)
    for _ in range(500):
        np.testing.assert_array_equal(
            estimator.update(monitor.trim, body.step(monitor.trim, unequal)), 1
        )
    for _ in range(100):
        estimate = estimator.update(monitor.trim, body.step(monitor.trim, later))
    assert estimate[1] == pytest.approx(0.8, abs=0.04)
    np.testing.assert_array_equal(np.delete(estimate, 1), 1)


def test_a_recovery_is_detected(monitor):
    body = Body(monitor)
    estimator = Estimator(monitor, body.sample)
    for k in range(600):
        body.step(monitor.trim, effectiveness_with(1, 0.5) if 200 <= k < 400 else 1.0)
        estimate = estimator.update(monitor.trim, body.sample)
        if k == 390:
            assert estimate[1] == pytest.approx(0.5, abs=0.05)
    assert np.all(estimate > 0.9)


forces = st.tuples(*[st.floats(-30, 30)] * 3)


@settings(max_examples=40)
@given(forces)
def test_a_push_on_the_base_raises_no_alarm(force):
    """Any force at the base's origin."""
    estimate = follow(_MONITOR[0], 200, 100, force=np.array(force))
    np.testing.assert_array_equal(estimate, 1)


@settings(max_examples=40)
@given(st.floats(0, 2), st.floats(-0.05, 0.05), st.floats(0.15, 0.25))
def test_a_load_at_the_tool_raises_no_alarm(mass, x, y):
    estimate = follow(_MONITOR[0], 200, 0, force=np.array([0, 0, -mass * GRAVITY]), at=(x, y, -0.3))
    np.testing.assert_array_equal(estimate, 1)


@settings(max_examples=40)
@given(st.lists(st.floats(0, 0.55), min_size=ROTORS, max_size=ROTORS))
def test_simultaneous_partial_losses_are_no_lost_rotor(missing):
    estimate = follow(_MONITOR[0], 120, 60, effectiveness=1 - np.array(missing))
    assert np.all(estimate > 0.4)


def test_rejected_samples_are_not_used(monitor):
    body, rng = Body(monitor), np.random.default_rng(4)
    estimator = Estimator(monitor, body.sample)
    for k in range(300):
        sample, is_valid = body.step(monitor.trim), not 100 <= k < 200
        if not is_valid:
            parts = (rng.choice([np.nan, 1e9, -1e9], size=len(part)) for part in sample[:3])
            sample = MomentumSample(*parts, is_valid=False)
        estimate = estimator.update(monitor.trim, sample)
        np.testing.assert_array_equal(estimate, 1)
    body.step(monitor.trim, effectiveness_with(3, 0.0))
    for _ in range(10):
        sample = body.step(monitor.trim, effectiveness_with(3, 0.0))
        estimate = estimator.update(monitor.trim, sample)
    assert estimate[3] < 0.4


@pytest.mark.parametrize("steps", [1, 3])
def test_delayed_samples_are_compared_with_delayed_thrusts(vehicle, trim, steps):
    """Steps of single commands raise no alarm, unless a delay is not accounted for."""

    def least_estimate(delay_s: float) -> float:
        monitor = RotorMonitor.make(vehicle, Rotor(), trim, delay_s, DT)
        body, rng, least = Body(monitor), np.random.default_rng(5), 1.0
        estimator = Estimator(monitor, body.sample)
        samples = [body.sample] * steps
        for k in range(400):
            if k % 10 == 0:
                command = trim.copy()
                command[rng.integers(ROTORS)] += rng.uniform(-9, 9)
            samples.append(body.step(command))
            least = min(least, *estimator.update(command, samples.pop(0)))
        return least

    assert least_estimate(steps * DT) == 1
    assert steps < 3 or least_estimate(0.0) < 0.9


def test_momentum_agrees_with_the_mass_matrix(vehicle):
    """The first six rows of M v are the momentum about the base's origin."""
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(6)
    x = vehicle.trim_state + np.concatenate([np.zeros(4), rng.uniform(-0.5, 0.5, 21)])
    plant.SetPositionsAndVelocities(context, x)
    about_base = (plant.CalcMassMatrix(context) @ plant.GetVelocities(context))[:6]
    momentum, r_BC = WholeBody(vehicle.plant).momentum(x)
    np.testing.assert_allclose(momentum[3:], about_base[3:], atol=1e-12)
    np.testing.assert_allclose(
        momentum[:3] + np.cross(r_BC, momentum[3:]), about_base[:3], atol=1e-12
    )


@pytest.mark.parametrize("every", [2, 4])
def test_a_loss_is_reported_from_rare_samples(vehicle, trim, every):
    """Samples in between are rejected, as those of a slow sensor are."""
    monitor = RotorMonitor.make(vehicle, Rotor(), trim, 0.0, DT, every)
    body, rng = Body(monitor), np.random.default_rng(0)
    estimator = Estimator(monitor, body.sample)
    for k in range(1, 400):
        command = monitor.trim + rng.normal(size=ROTORS)
        sample = body.step(command, effectiveness_with(2, 0.5) if k >= 200 else 1.0)
        effectiveness = estimator.update(command, NO_SAMPLE if k % every else sample)
        if k == 199:
            np.testing.assert_array_equal(effectiveness, 1)
    np.testing.assert_allclose(effectiveness, effectiveness_with(2, 0.5), atol=0.05)

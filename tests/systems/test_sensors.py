"""Sensors: when they sample what, exact by default, and noise of the asked size by the seed."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common import RandomDistribution
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    LogVectorOutput,
    RandomSource,
    TrajectorySource,
    VectorLogSink,
    ZeroOrderHold,
)
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.model.sensing.sample import noise_size
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Sensors
from aerodrake.station import make_context, make_station
from aerodrake.systems.sensors import SensorSystem

JOINTS = 6
SIZE = VehicleState.size(JOINTS)
PERIOD, OFFSET = 0.01, 0.009
NOISY = Sensors(
    position_noise_m=0.01,
    velocity_noise_m_s=0.2,
    attitude_noise_rad=0.003,
    rate_noise_rad_s=0.05,
    joint_noise_rad=0.001,
)
EACH = {
    "position_noise_m": "p_B",
    "velocity_noise_m_s": "v_B",
    "attitude_noise_rad": "quaternion",
    "rate_noise_rad_s": "omega_W",
    "joint_noise_rad": "q",
}
"""Which part of the state each standard deviation is about."""


def truth() -> np.ndarray:
    """A state of which no two numbers are alike."""
    x = 0.3 + 0.1 * np.arange(SIZE)
    x[:4] = RollPitchYaw(0.3, -0.2, 0.5).ToQuaternion().wxyz()
    return x


def make_noisy(config: Sensors) -> tuple[Diagram, VectorLogSink]:
    """Sensors that look at a vehicle at rest, and a log of what they say."""
    builder = DiagramBuilder()
    sensors = builder.AddSystem(SensorSystem(config, JOINTS, PERIOD, OFFSET, np.zeros(SIZE)))
    source = builder.AddSystem(ConstantVectorSource(truth()))
    noise = builder.AddSystem(
        RandomSource(RandomDistribution.kGaussian, noise_size(JOINTS), PERIOD)
    )
    for port in ("true_state", "late_state"):
        builder.Connect(source.get_output_port(), sensors.GetInputPort(port))
    builder.Connect(noise.get_output_port(), sensors.GetInputPort("noise"))
    log = LogVectorOutput(sensors.GetOutputPort("state"), builder, PERIOD)
    return builder.Build(), log


def measure(config: Sensors, samples: int, seed: int = 0) -> np.ndarray:
    """(samples, 13 + 2 n)"""
    diagram, log = make_noisy(config)
    context = make_context(diagram, seed)
    Simulator(diagram, context).AdvanceTo(samples * PERIOD)
    return log.FindLog(context).data().T[1:]  # At time 0 there was none yet.


def turns(states: np.ndarray) -> np.ndarray:
    """(samples, 3) rad, rotation vectors from the true to the measured attitude."""
    R = RotationMatrix(Quaternion(truth()[:4]))
    measured = (R.inverse().multiply(RotationMatrix(Quaternion(x[:4]))) for x in states)
    return np.array([a.angle() * a.axis() for a in (m.ToAngleAxis() for m in measured)])


def test_exact_by_default_without_a_look_at_the_noise():
    sensors = SensorSystem(Sensors(base_delay_s=0.1), JOINTS, PERIOD, OFFSET, np.zeros(SIZE))
    simulator = Simulator(sensors)
    context = simulator.get_mutable_context()
    x = np.linspace(-1, 2, SIZE)
    sensors.GetInputPort("true_state").FixValue(context, x)
    sensors.GetInputPort("late_state").FixValue(context, x)
    simulator.AdvanceTo(OFFSET)
    np.testing.assert_array_equal(sensors.GetOutputPort("state").Eval(context), np.zeros(SIZE))
    simulator.AdvanceTo(PERIOD)
    np.testing.assert_array_equal(sensors.GetOutputPort("state").Eval(context), x)


def test_stamps_tell_when_a_sample_was_taken():
    """That of time 0 as if there had been one a period before."""
    sensors = SensorSystem(Sensors(), JOINTS, PERIOD, OFFSET, np.zeros(SIZE))
    simulator = Simulator(sensors)
    context = simulator.get_mutable_context()
    for port in ("true_state", "late_state"):
        sensors.GetInputPort(port).FixValue(context, np.zeros(SIZE))
    for k in range(4):
        simulator.AdvanceTo(k * PERIOD)
        stamps = sensors.GetOutputPort("stamps").Eval(context)
        np.testing.assert_allclose(stamps, (k - 1) * PERIOD + OFFSET, atol=1e-12)


def test_the_arm_is_sampled_from_the_true_state_and_the_base_from_the_late_one():
    sensors = SensorSystem(Sensors(), JOINTS, PERIOD, OFFSET, np.zeros(SIZE))
    simulator = Simulator(sensors)
    context = simulator.get_mutable_context()
    sensors.GetInputPort("true_state").FixValue(context, np.full(SIZE, 1.0))
    sensors.GetInputPort("late_state").FixValue(context, np.full(SIZE, 2.0))
    simulator.AdvanceTo(PERIOD)
    n = JOINTS
    expected = np.repeat([2.0, 1.0, 2.0, 1.0], [7, n, 6, n])
    np.testing.assert_array_equal(sensors.GetOutputPort("state").Eval(context), expected)


def test_a_consumer_of_the_same_instant_sees_the_new_sample():
    """Drake's own sample-and-hold after the sensors adds little, after itself a period."""
    builder = DiagramBuilder()
    ramp = PiecewisePolynomial.FirstOrderHold([0, 10], np.outer(np.ones(SIZE), [0, 10]))
    source = builder.AddSystem(TrajectorySource(ramp))
    sensors = builder.AddSystem(SensorSystem(Sensors(), JOINTS, PERIOD, OFFSET, np.zeros(SIZE)))
    first = builder.AddSystem(ZeroOrderHold(PERIOD, SIZE))
    second = builder.AddSystem(ZeroOrderHold(PERIOD, SIZE))
    for port in ("true_state", "late_state"):
        builder.Connect(source.get_output_port(), sensors.GetInputPort(port))
    builder.Connect(sensors.GetOutputPort("state"), first.get_input_port())
    builder.Connect(first.get_output_port(), second.get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_context()
    for time, sampled in ((0.0950, 0.089), (0.0989, 0.089), (0.1001, 0.099), (0.1089, 0.099)):
        simulator.AdvanceTo(time)
        for system, expected in ((sensors, sampled), (first, sampled), (second, sampled - PERIOD)):
            seen = system.get_output_port(0).Eval(system.GetMyContextFromRoot(context))
            np.testing.assert_allclose(seen, expected, atol=1e-12, err_msg=f"{system} {time}")


def test_no_feedthrough():
    sensors = SensorSystem(NOISY, JOINTS, PERIOD, OFFSET, truth())
    assert not sensors.HasAnyDirectFeedthrough()


def test_noise_is_white_and_of_the_asked_size_on_every_axis():
    samples = 5000
    states = measure(NOISY, samples)
    n = JOINTS
    attitude = turns(states)
    errors = np.hstack([attitude, (states - truth())[:, 4:]])
    deviations = np.repeat([0.003, 0.01, 0.001, 0.05, 0.2, 0.0], [3, 3, n, 3, 3, n])
    noisy = deviations > 0
    np.testing.assert_array_equal(errors[:, ~noisy], 0)

    drawn = errors[:, noisy] / deviations[noisy]
    np.testing.assert_allclose(drawn.std(axis=0), 1, atol=0.05)
    np.testing.assert_allclose(drawn.mean(axis=0), 0, atol=0.06)
    # No axis shares its draws with another one, or with the sample before.
    both = np.hstack([drawn[1:], drawn[:-1]])
    np.testing.assert_allclose(np.corrcoef(both.T), np.eye(both.shape[1]), atol=0.075)
    np.testing.assert_allclose(np.linalg.norm(states[:, :4], axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("key", EACH)
def test_each_deviation_is_about_one_part_alone(key):
    states = measure(Sensors(**{key: 0.01}), 20)
    for part in ("quaternion", "p_B", "q", "omega_W", "v_B", "qdot"):
        error = [
            getattr(split_state(x), part) - getattr(split_state(truth()), part) for x in states
        ]
        largest = np.abs(error).max(axis=0)
        assert np.all(largest > 1e-4) if part == EACH[key] else np.all(largest < 1e-15), part


def test_noise_depends_on_the_seed_alone():
    first, again, other = (measure(NOISY, 20, seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    assert np.all(first[:, 4:-JOINTS] != other[:, 4:-JOINTS])


def test_the_seed_reaches_the_noise_of_a_station(scenario, vehicle):
    station = make_station(replace(scenario, sensors=NOISY))
    seen = []
    for seed in (0, 0, 1):
        context = make_context(station, seed)
        hover = np.concatenate([vehicle.p_B, np.zeros(6)])
        folded = np.concatenate([vehicle.working, np.zeros(2 * vehicle.joints)])
        station.GetInputPort("base_setpoint").FixValue(context, hover)
        station.GetInputPort("joint_setpoint").FixValue(context, folded)
        np.testing.assert_array_equal(
            station.GetOutputPort("state").Eval(context), vehicle.trim_state
        )
        Simulator(station, context).AdvanceTo(0.025)
        seen.append(station.GetOutputPort("state").Eval(context))
    np.testing.assert_array_equal(seen[0], seen[1])
    assert np.all(seen[0][4:7] != seen[2][4:7])

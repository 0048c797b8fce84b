"""Sensors: instants of sampling, exact samples by default, and size and seed of the noise."""

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
"""The part of the state that each standard deviation applies to."""


def truth() -> np.ndarray:
    """Returns a state whose numbers all differ."""
    x = 0.3 + 0.1 * np.arange(SIZE)
    x[:4] = RollPitchYaw(0.3, -0.2, 0.5).ToQuaternion().wxyz()
    return x


def make_noisy(config: Sensors) -> tuple[Diagram, VectorLogSink]:
    """Returns sensors that sample a constant state, and a log of their samples."""
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
    """Returns the samples (samples, 13 + 2 n)."""
    diagram, log = make_noisy(config)
    context = make_context(diagram, seed)
    Simulator(diagram, context).AdvanceTo(samples * PERIOD)
    return log.FindLog(context).data().T[1:]  # The first row, at time 0, is the initial value.


def turns(states: np.ndarray) -> np.ndarray:
    """Returns rotation vectors (samples, 3) rad from the true to the measured attitude."""
    R = RotationMatrix(Quaternion(truth()[:4]))
    measured = (R.inverse().multiply(RotationMatrix(Quaternion(x[:4]))) for x in states)
    return np.array([a.angle() * a.axis() for a in (m.ToAngleAxis() for m in measured)])


def test_samples_are_exact_by_default_without_evaluating_the_noise():
    sensors = SensorSystem(Sensors(), JOINTS, PERIOD, OFFSET, np.zeros(SIZE))
    simulator = Simulator(sensors)
    context = simulator.get_mutable_context()
    x = np.linspace(-1, 2, SIZE)
    np.testing.assert_array_equal(sensors.GetOutputPort("state").Eval(context), np.zeros(SIZE))
    sensors.GetInputPort("true_state").FixValue(context, x)
    sensors.GetInputPort("late_state").FixValue(context, x)
    simulator.AdvanceTo(PERIOD)
    np.testing.assert_array_equal(sensors.GetOutputPort("state").Eval(context), x)


def test_stamps_are_the_times_of_the_samples():
    """The initial stamp is one period before the first sample's."""
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
    """Drake's sample-and-hold adds no delay after the sensors, and a period after another."""
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
    for time, instant in ((0.0950, 0.089), (0.0989, 0.089), (0.1001, 0.099), (0.1089, 0.099)):
        simulator.AdvanceTo(time)
        for system, expected in ((sensors, instant), (first, instant), (second, instant - PERIOD)):
            state = system.get_output_port(0).Eval(system.GetMyContextFromRoot(context))
            np.testing.assert_allclose(state, expected, atol=1e-12, err_msg=f"{system} {time}")


def test_no_feedthrough():
    sensors = SensorSystem(NOISY, JOINTS, PERIOD, OFFSET, truth())
    assert not sensors.HasAnyDirectFeedthrough()


def test_noise_is_white_and_of_the_configured_size_on_every_axis():
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
    # No axis shares its draws with another one, or with the previous sample.
    both = np.hstack([drawn[1:], drawn[:-1]])
    np.testing.assert_allclose(np.corrcoef(both.T), np.eye(both.shape[1]), atol=0.075)
    np.testing.assert_allclose(np.linalg.norm(states[:, :4], axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("key", EACH)
def test_each_deviation_applies_to_one_part_alone(key):
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
    states = []
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
        states.append(station.GetOutputPort("state").Eval(context))
    np.testing.assert_array_equal(states[0], states[1])
    assert np.all(states[0][4:7] != states[2][4:7])

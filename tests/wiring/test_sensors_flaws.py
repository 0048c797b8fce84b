"""Flaws of the sensors on a known motion: each sample is that of a known time."""

from typing import NamedTuple

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
from scipy.spatial.transform import Rotation
from scipy.stats import chisquare

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import (
    Accelerometer,
    AttitudeSensor,
    Filter,
    JointSensors,
    PositionSensor,
    Scenario,
    Sensors,
    ToolSensor,
)
from aerodrake.station import leaf_systems, make_context
from aerodrake.wiring.sensors import RATES, make_sensors

JOINTS, STEP, PERIOD = 6, 0.001, 0.010
SPIN, A_X, RATE = np.array([0.1, -0.2, 0.3]), 2.0, 0.5


def motion(t: float) -> np.ndarray:
    """Returns the state at a time: p_B = (t, t^2, t^3), constant rates of base and joints."""
    state = VehicleState.at_rest(np.array([t, A_X / 2 * t**2, t**3]), np.full(JOINTS, RATE * t))
    return state._replace(
        quaternion=Rotation.from_rotvec(SPIN * t).as_quat(scalar_first=True),
        omega_W=SPIN,
        v_B=np.array([1.0, A_X * t, 3 * t**2]),
        qdot=np.full(JOINTS, RATE),
    ).to_vector()


class Mover(LeafSystem):
    """Moves in steps, like a discrete plant."""

    def __init__(self):
        super().__init__()
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(STEP, 0.0, self._update)
        size = VehicleState.size(JOINTS)
        self.DeclareVectorOutputPort("state", size, self._calc)

    def _update(self, context, discrete):
        discrete.set_value([context.get_discrete_state_vector()[0] + 1])

    def _calc(self, context, output):
        output.set_value(motion(context.get_discrete_state_vector()[0] * STEP))


class Run(NamedTuple):
    """Outputs of the sensors by port, a row each time, shortly after the multiples of a period."""

    times: np.ndarray
    outputs: dict[str, np.ndarray]

    def __getitem__(self, port: str) -> np.ndarray:
        return self.outputs[port]

    @property
    def states(self) -> VehicleState:
        return split_state(self["sample"].T)


def run(vehicle, sensors: Sensors, duration: float, every: float = PERIOD, **other) -> Run:
    scenario = Scenario(sensors=sensors, **other)
    builder = DiagramBuilder()
    sensing = builder.AddSystem(
        make_sensors(scenario, vehicle.trim_state, np.zeros(6), vehicle=vehicle)
    )
    mover = builder.AddNamedSystem("mover", Mover())
    builder.Connect(mover.get_output_port(), sensing.GetInputPort("true_state"))
    for port, size in (("acceleration", 6), ("reaction", 3), ("joint_setpoint", 3 * JOINTS)):
        none = builder.AddNamedSystem(port, ConstantVectorSource(np.zeros(size)))
        builder.Connect(none.get_output_port(), sensing.GetInputPort(port))
    diagram = builder.Build()
    context = make_context(diagram, 0)
    simulator, own = Simulator(diagram, context), sensing.GetMyContextFromRoot(context)
    sampler = sensing.GetSubsystemByName("sampler")
    ports = {
        sensing.get_output_port(i).get_name(): sensing.get_output_port(i)
        for i in range(sensing.num_output_ports())
    }
    rows: dict[str, list] = {name: [] for name in (*ports, "stamps")}
    times = every * np.arange(1, round(duration / every) + 1)
    for time in times:
        simulator.AdvanceTo(time)
        for name, port in ports.items():
            rows[name].append(port.Eval(own).copy())
        stamps = sampler.GetOutputPort("stamps").Eval(sampler.GetMyContextFromRoot(context))
        rows["stamps"].append(stamps.copy())
    return Run(times, {name: np.array(values) for name, values in rows.items()})


@pytest.fixture(scope="module")
def irregular(vehicle) -> Run:
    """Each group with a rate, a latency and stamps of its own, and a tool sensor."""
    sensors = Sensors(
        base_delay_s=0.01,
        position=PositionSensor(period_s=0.02, latency_s=(0.002, 0.009), stamp="arrival"),
        attitude=AttitudeSensor(period_s=0.005, latency_s=(0.0, 0.004)),
        joints=JointSensors(latency_s=(0.003, 0.003), loss=0.25),
        tool=ToolSensor(period_s=0.02, delay_s=0.02, mounting_m=(0.01, 0.02, 0.03)),
    )
    return run(vehicle, sensors, 8.0)


def test_a_position_is_that_of_delay_and_latency_before_its_arrival(irregular):
    content, arrival = irregular.states.p_B[0], irregular["stamps"][:, 0] + STEP / 4
    np.testing.assert_allclose(irregular.states.p_B[2][1:], content[1:] ** 3, atol=1e-9)
    np.testing.assert_allclose(arrival[1::2], irregular.times[1::2], atol=1e-9)
    latency = np.round((arrival - content)[1::2] / STEP) - 10
    np.testing.assert_allclose((arrival - content)[1::2] / STEP - 10, latency, atol=1e-6)
    steps, counts = np.unique(latency, return_counts=True)
    np.testing.assert_array_equal(steps, np.arange(2, 10))
    assert chisquare(counts).pvalue > 0.01
    # Between its samples a sensor holds the last one.
    np.testing.assert_array_equal(irregular["sample"][1:-1:2, 4:7], irregular["sample"][2::2, 4:7])


def test_true_stamps_are_the_times_of_the_content_plus_the_known_delay(irregular):
    turn = Rotation.from_quat(irregular.states.quaternion.T, scalar_first=True).as_rotvec()
    content = turn @ SPIN / (SPIN @ SPIN)
    stamps = irregular["stamps"][:, 1] + STEP / 4
    np.testing.assert_allclose(content, stamps - 0.01, atol=1e-9)
    late = np.round((irregular.times - stamps) / STEP)
    assert set(late) == set(range(5))  # The newer of two samples each time.


def test_lost_samples_do_not_arrive_and_a_constant_latency_is_constant(irregular):
    content, stamps = irregular.states.q[0] / RATE, irregular["stamps"][:, 2] + STEP / 4
    np.testing.assert_allclose(content, stamps, atol=1e-9)
    is_new = np.diff(stamps, prepend=0) > 0
    assert np.mean(~is_new) == pytest.approx(0.25, abs=0.05)
    np.testing.assert_allclose(stamps[is_new], irregular.times[is_new] - 0.003, atol=1e-9)


def test_the_tool_is_measured_with_its_delay_and_its_mounting(irregular, vehicle):
    kinematics = Kinematics(vehicle.plant)
    for k in (101, 301):
        state = split_state(motion(irregular.times[k] - 0.02))
        X = kinematics.tool_pose(state.q)
        mounted = X.translation() + X.rotation().matrix() @ [0.01, 0.02, 0.03]
        expected = state.p_B + state.R_B @ mounted
        np.testing.assert_allclose(irregular["tool_position"][k], expected, atol=1e-9)


def test_the_accelerometer_measures_the_difference_of_velocities(vehicle):
    """Its output is the mean of both samples in a period of the sensors."""
    sensors = Sensors(
        base_delay_s=0.005,
        accelerometer=Accelerometer(period_s=0.005, bias_m_s2=(0.1, 0.2, 0.3)),
    )
    result = run(vehicle, sensors, 0.3)
    for t, force in zip(result.times[5:], result["specific_force"][5:], strict=True):
        forces = []
        for end in (t - 0.005, t - 0.010):
            before, after = split_state(motion(end - 0.005)), split_state(motion(end))
            a = (after.v_B - before.v_B) / 0.005 + [0, 0, 9.81]
            forces.append((before.R_B + after.R_B).T / 2 @ a)
        np.testing.assert_allclose(force, np.mean(forces, axis=0) + [0.1, 0.2, 0.3], atol=1e-9)
    np.testing.assert_allclose(result["specific_force_stamp"][:, 0], result.times - STEP / 4)


def test_noise_of_the_accelerometer_is_white_and_of_its_size(vehicle):
    sensors = Sensors(accelerometer=Accelerometer(period_s=0.01, noise_m_s2=2.0))
    exact = Sensors(accelerometer=Accelerometer(period_s=0.01))
    force = (
        run(vehicle, sensors, 5.0)["specific_force"] - run(vehicle, exact, 5.0)["specific_force"]
    )
    np.testing.assert_allclose(force.std(axis=0), 2.0, rtol=0.15)
    assert np.abs(np.corrcoef(force[1:].T, force[:-1].T) - np.eye(6)).max() < 0.2


def test_the_gyroscope_drifts_from_its_bias(vehicle):
    attitude = AttitudeSensor(rate_bias_rad_s=(0.01, 0, 0), rate_drift_rad_s2=0.02)
    measured = run(vehicle, Sensors(attitude=attitude), 2.0)
    R = Rotation.from_quat(measured.states.quaternion.T, scalar_first=True)
    bias = R.inv().apply(measured.states.omega_W.T - SPIN)
    steps = np.diff(bias, axis=0)
    np.testing.assert_allclose(steps.std(axis=0), 0.02 * np.sqrt(PERIOD), rtol=0.15)
    np.testing.assert_allclose(bias[0], [0.01, 0, 0], atol=4 * 0.02 * np.sqrt(PERIOD))


def test_encoders_step_and_their_rates_are_filtered_differences(vehicle):
    joints = JointSensors(resolution_bits=10, rate="difference", rate_filter_s=0.02, period_s=0.005)
    measured = run(vehicle, Sensors(joints=joints), 0.5, every=0.005)
    quantum = 2 * np.pi / 2**10
    expected = quantum * np.rint(RATE * measured.times / quantum)
    np.testing.assert_allclose(measured.states.q, np.tile(expected, (JOINTS, 1)), atol=1e-12)
    rate, last = RATE, 0.0
    for q, qdot in zip(expected, measured.states.qdot[0], strict=True):
        rate += (1 - np.exp(-0.005 / 0.02)) * ((q - last) / 0.005 - rate)
        last = q
        assert qdot == pytest.approx(rate)


def test_an_invisible_tool_is_not_measured(vehicle):
    """The tool points straight down at first, and the base tilts."""
    tool = ToolSensor(period_s=0.01, visible_rad=0.5)
    result = run(vehicle, Sensors(tool=tool), 4.0, every=0.1)
    down = np.array([split_state(motion(t)).R_B for t in result.times])
    pose = Kinematics(vehicle.plant).tool_pose
    axes = [pose(split_state(motion(t)).q).rotation().matrix()[:, 2] for t in result.times]
    angle = np.arccos([(R @ axis)[2] for R, axis in zip(down, axes, strict=True)])
    is_new = np.isclose(result["tool_stamp"][:, 0], result.times - STEP / 4)
    np.testing.assert_array_equal(is_new, angle <= 0.5)
    assert 0 < is_new.sum() < len(is_new)


@pytest.mark.parametrize("loss", [0.0, 1e-9])
def test_encoders_may_measure_other_joints(vehicle, loss):
    """With and without past states."""
    scenario = Scenario(sensors=Sensors(joints=JointSensors(loss=loss)))
    diagram = make_sensors(scenario, vehicle.trim_state, np.zeros(6), has_encoder_state=True)
    context = make_context(diagram, 0)
    for port, size in (("acceleration", 6), ("reaction", 3), ("joint_setpoint", 3 * JOINTS)):
        diagram.GetInputPort(port).FixValue(context, np.zeros(size))
    diagram.GetInputPort("true_state").FixValue(context, motion(1.0))
    diagram.GetInputPort("encoder_state").FixValue(context, motion(2.0))
    Simulator(diagram, context).AdvanceTo(2 * PERIOD)
    sample = split_state(diagram.GetOutputPort("sample").Eval(context))
    np.testing.assert_array_equal(sample.q, 2 * RATE)
    np.testing.assert_array_equal(sample.p_B, split_state(motion(1.0)).p_B)


EVERY = Sensors(
    attitude=AttitudeSensor(rate_drift_rad_s2=0.01),
    accelerometer=Accelerometer(period_s=0.005),
    tool=ToolSensor(period_s=0.02),
)


def test_table_of_rates(vehicle):
    """Every periodic update of the systems of flaws is in the table, with period and offset."""
    scenario = Scenario(sensors=EVERY, filter=Filter(accelerometer_noise_m_s2=0.05))
    sensors = make_sensors(scenario, vehicle.trim_state, np.zeros(6), vehicle=vehicle)
    systems = {system.get_name(): system for system in leaf_systems(sensors)}
    for rate in RATES:
        for name in rate.systems:
            attribute = systems[name].GetUniquePeriodicDiscreteUpdateAttribute()
            if rate.kind == "unrestricted":
                assert attribute is None
                continue
            section, *keys = rate.period.split(".")
            period = getattr(scenario, section)
            for key in keys:
                period = getattr(period, key)
            assert attribute.period_sec() == pytest.approx(period)
            assert attribute.offset_sec() == pytest.approx(rate.offset_steps * STEP % period)

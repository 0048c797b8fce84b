"""Flights with the flaws of sensors: what is logged, accepted and repeated."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from scipy.spatial.transform import Rotation

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.sensing.sample_health import Verdict
from aerodrake.scenario import (
    Accelerometer,
    AttitudeSensor,
    Clover,
    Filter,
    JointSensors,
    PositionSensor,
    Scenario,
    Sensors,
    ToolSensor,
)
from aerodrake.station import make_closed_loop, make_context

BESIDE = Sensors(
    accelerometer=Accelerometer(period_s=0.01), tool=ToolSensor(period_s=0.02, delay_s=0.02)
)
"""Sensors that no controller uses."""

FIELD = Sensors(
    position_noise_m=0.002,
    velocity_noise_m_s=0.02,
    attitude_noise_rad=0.0035,
    rate_noise_rad_s=0.01,
    joint_noise_rad=0.0009,
    base_delay_s=0.01,
    position=PositionSensor(period_s=0.02, latency_s=(0.0, 0.01), stamp="arrival"),
    attitude=AttitudeSensor(period_s=0.005, rate_bias_rad_s=(0.01, 0.01, 0.01)),
    joints=JointSensors(resolution_bits=12, rate="difference", rate_filter_s=0.005),
    accelerometer=Accelerometer(period_s=0.005, noise_m_s2=0.05),
)
FILTER = Filter(delay_s=0.01, velocity_noise_m_s=0.02, accelerometer_noise_m_s2=0.3)
BASE = Scenario(duration=1.5, settle_s=0.5, reference=Clover(start_s=0.5))


@pytest.fixture(scope="module")
def beside() -> FlightLog:
    return FlightSimulation(replace(BASE, sensors=BESIDE)).fly()


@pytest.fixture(scope="module")
def field() -> FlightLog:
    return FlightSimulation(replace(BASE, sensors=FIELD, filter=FILTER)).fly()


def test_sensors_that_are_not_used_change_no_bit(beside):
    plain = FlightSimulation(BASE).fly()
    for key in plain:
        if not key.endswith("_ms"):
            np.testing.assert_array_equal(plain[key], beside[key], err_msg=key)
    assert beside.keys() - plain.keys() == {
        "measured_specific_force_m_s2",
        "specific_force_stamp_s",
        "measured_p_E_m",
        "tool_stamp_s",
    }


def test_the_accelerometer_measures_the_difference_of_true_velocities(beside):
    R = Rotation.from_quat(beside["quaternion"], scalar_first=True).as_matrix()
    a = np.diff(beside["v_B_m_s"], axis=0) / 0.01 + [0, 0, 9.81]
    expected = np.einsum("tji,tj->ti", (R[1:] + R[:-1]) / 2, a)
    np.testing.assert_allclose(beside["measured_specific_force_m_s2"][1:], expected, atol=1e-9)
    assert np.abs(np.diff(beside["v_B_m_s"], axis=0)).max() > 1e-4


def test_the_tool_is_measured_with_its_delay(beside):
    """In rows of the log, every 10 ms; its samples are every 20 ms."""
    rows = np.arange(50, 200, 2)
    np.testing.assert_allclose(
        beside["measured_p_E_m"][rows], beside["p_E_m"][rows - 2], atol=1e-12
    )
    np.testing.assert_array_equal(
        beside["measured_p_E_m"][rows + 1], beside["measured_p_E_m"][rows]
    )


def test_declared_flaws_are_not_taken_for_faults(field):
    verdicts = field["sample_verdict"].astype(int)
    np.testing.assert_array_equal(np.bincount(verdicts[:, 0]), [101, 0, 100])
    np.testing.assert_array_equal(verdicts[:, 1:], Verdict.OK)
    assert field.exit_reason == "completed"
    assert not field["supervisor_mode"].any()
    assert field.error_m.max() < 0.02


def test_a_flight_with_flaws_is_the_same_again(field):
    again = FlightSimulation(replace(BASE, sensors=FIELD, filter=FILTER)).fly()
    for key in field:
        if not key.endswith("_ms"):
            np.testing.assert_array_equal(field[key], again[key], err_msg=key)


def test_a_cloned_context_continues_alike():
    scenario = replace(BASE, sensors=replace(FIELD, tool=BESIDE.tool), filter=FILTER)
    loop = make_closed_loop(scenario)
    simulator = Simulator(loop, make_context(loop, 0))
    simulator.AdvanceTo(0.1037)
    other = Simulator(loop, simulator.get_context().Clone())
    other.Initialize()
    for each in (simulator, other):
        each.AdvanceTo(0.2)
    for name in ("true_state", "state", "sample", "specific_force", "tool_position"):
        a, b = (loop.GetOutputPort(name).Eval(each.get_context()) for each in (simulator, other))
        np.testing.assert_array_equal(a, b, err_msg=name)

"""Diagram of the sensors: the instant of each sample, with and without delay."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, DiscreteTimeIntegrator, RandomSource

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.scenario import Payload, Push, Rates, SampleJump, SampleNan, Scenario, Sensors
from aerodrake.station import make_context
from aerodrake.wiring.sensors import make_sensors

JOINTS = 6
STEP, PERIOD = 0.001, 0.010
SLOPE = np.linspace(1.0, 2.0, 13 + 2 * JOINTS)
BASE = np.repeat([True, False, True, False], [7, JOINTS, 6, JOINTS])


def make_moving(config: Sensors, trim: np.ndarray, rates: Rates) -> Diagram:
    """Returns sensors of a state that starts in trim and changes by SLOPE in each plant step."""
    builder = DiagramBuilder()
    slope = builder.AddSystem(ConstantVectorSource(SLOPE / rates.plant_step_s))
    mover = builder.AddNamedSystem("mover", DiscreteTimeIntegrator(len(SLOPE), rates.plant_step_s))
    sensors = builder.AddSystem(
        make_sensors(Scenario(sensors=config, rates=rates), trim, np.zeros(6))
    )
    builder.Connect(slope.get_output_port(), mover.get_input_port())
    builder.Connect(mover.get_output_port(), sensors.GetInputPort("true_state"))
    for port, size in (("acceleration", 6), ("reaction", 3), ("joint_setpoint", 3 * JOINTS)):
        none = builder.AddNamedSystem(port, ConstantVectorSource(np.zeros(size)))
        builder.Connect(none.get_output_port(), sensors.GetInputPort(port))
    builder.ExportOutput(sensors.GetOutputPort("sample"), "sample")
    return builder.Build()


def sampled(config: Sensors, trim: np.ndarray, rates: Rates, instants: int) -> np.ndarray:
    """Returns the samples (instants, 13 + 2 n) at the multiples of the period, from 0 on.

    `mover` starts at `trim` too.
    """
    diagram = make_moving(config, trim, rates)
    context = diagram.CreateDefaultContext()
    mover = diagram.GetSubsystemByName("mover")
    mover.set_integral_value(mover.GetMyMutableContextFromRoot(context), trim)
    simulator = Simulator(diagram, context)
    states = []
    for k in range(instants):
        simulator.AdvanceTo(k * rates.sensor_period_s)
        states.append(diagram.get_output_port().Eval(context).copy())
    return np.array(states)


@settings(max_examples=25)
@given(
    delay=st.integers(0, 35),
    ticks=st.integers(1, 12),
    step=st.sampled_from([0.0005, 0.001, 0.002]),
)
def test_a_sample_has_the_base_of_a_delay_ago_and_the_arm_of_its_instant(
    vehicle, delay, ticks, step
):
    """For delays of whole plant steps. Before time 0 the state is that of trim."""
    assume(ticks * step >= 0.002)  # The shortest period of all systems.
    rates, trim = Rates(step, *[ticks * step] * 4), vehicle.trim_state
    states = sampled(Sensors(base_delay_s=delay * step), trim, rates, 12)
    steps = ticks * np.arange(12)[:, np.newaxis]
    expected = trim + np.where(BASE, np.maximum(steps - delay, 0), steps) * SLOPE
    np.testing.assert_allclose(states, expected, rtol=1e-12, atol=1e-12)


def test_a_delay_outputs_trim_bit_for_bit(vehicle):
    rates = Rates()
    diagram = make_moving(Sensors(base_delay_s=0.2), vehicle.trim_state, rates)
    context = diagram.CreateDefaultContext()
    mover = diagram.GetSubsystemByName("mover")
    mover.set_integral_value(mover.GetMyMutableContextFromRoot(context), vehicle.trim_state)
    simulator = Simulator(diagram, context)
    for time in (0.0, 0.05, 0.19):
        simulator.AdvanceTo(time)
        state = diagram.get_output_port().Eval(context)
        np.testing.assert_array_equal(state[BASE], vehicle.trim_state[BASE])


def test_without_a_delay_the_diagram_has_no_delay_line(vehicle):
    sensors = make_sensors(Scenario(), vehicle.trim_state, np.zeros(6))
    assert {s.get_name() for s in sensors.GetSystems()} == {
        "sensor_noise",
        "sampler",
        "state_filter",
    }
    assert not sensors.HasAnyDirectFeedthrough()


def test_faults_of_samples_are_systems_in_their_order_and_others_are_not(vehicle):
    faults = (SampleNan(group="joints"), Push(), SampleJump(group="position"))
    sensors = make_sensors(Scenario(faults=faults), vehicle.trim_state, np.zeros(6))
    assert [s.get_name() for s in sensors.GetSystems() if "fault" in type(s).__name__.lower()] == [
        "sample_nan_0",
        "sample_jump_2",
    ]


def test_noise_is_the_same_at_any_delay(vehicle):
    draws = []
    for delay in (0.0, 0.01):
        scenario = Scenario(sensors=Sensors(base_delay_s=delay))
        sensors = make_sensors(scenario, vehicle.trim_state, np.zeros(6))
        noise = sensors.GetSubsystemByName("sensor_noise")
        assert isinstance(noise, RandomSource)
        context = noise.GetMyContextFromRoot(make_context(sensors, 3))
        draws.append(noise.get_output_port().Eval(context))
    np.testing.assert_array_equal(*draws)


@pytest.fixture(scope="module")
def dropped():
    """A flight with a load from the start, which moves base and arm, and a delay of 20 ms."""
    scenario = Scenario(duration=0.5, settle_s=0.0, payload=Payload(mass_kg=0.5))
    return FlightSimulation(replace(scenario, sensors=Sensors(base_delay_s=0.02))).fly()


@pytest.mark.parametrize(
    ("key", "delay"),
    [
        ("quaternion", 2),
        ("p_B_m", 2),
        ("omega_W_rad_s", 2),
        ("v_B_m_s", 2),
        ("q_rad", 0),
        ("qdot_rad_s", 0),
    ],
)
def test_a_station_measures_its_base_with_a_delay(dropped, key, delay):
    """In rows of the log, every 10 ms."""
    true, measured = dropped[key], dropped[f"measured_{key}"]
    assert len(np.unique(true, axis=0)) == len(true)
    np.testing.assert_array_equal(measured[: delay + 1], true[[0] * (delay + 1)])
    np.testing.assert_allclose(measured[delay:], true[: len(true) - delay], rtol=0, atol=1e-15)

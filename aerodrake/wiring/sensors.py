"""Sensors as a diagram: samples of the state, noise, delay, faults, and the state filter."""

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import AffineSystem, DiscreteTimeDelay, RandomSource

from aerodrake.model.sensing.sample import noise_size
from aerodrake.model.sensing.sample_check import SampleCheck
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import SampleFault, Scenario
from aerodrake.systems.faults.samples import SampleFaultSystem
from aerodrake.systems.sensors import SensorSystem, is_exact
from aerodrake.systems.state_filter import StateFilterSystem
from aerodrake.wiring.replacements import Replacements


def make_sensors(
    scenario: Scenario,
    trim_state: np.ndarray,
    trim_acceleration: np.ndarray,
    replacements: Replacements | None = None,
) -> Diagram:
    """Makes the sensors: samples of the state, and an estimate of the present state.

    By default samples are exact and without delay. A sample is taken a quarter of a plant step
    before each multiple of the period, when the plant's state is already that of the multiple.
    All events at the multiple see the sample, whatever their kind.

    Inputs: `true_state` (13 + 2 n); `acceleration` (6) and `reaction` (3) of the flight
    controller and `joint_setpoint` (3 n), for the filter.
    Outputs: `sample` (13 + 2 n), the last one as it arrives; `state` (13 + 2 n), the filter's
    estimate, `trim_state` before the first sample; `external_acceleration` (3);
    `sample_health` (6), ages and verdicts of the sample's groups.

    Args:
        scenario: Noise, delay, filter, rates, and faults of samples. Faults apply one after
            another, in their order.
        trim_state: (13 + 2 n,) the state before time 0.
        trim_acceleration: (6,) that the flight controller models then.
        replacements: Of systems in the diagram.
    """
    joints, config = len(split_state(trim_state).q), scenario.sensors
    period, step = scenario.rates.sensor_period_s, scenario.rates.plant_step_s
    builder = (replacements or Replacements()).builder()
    sensor_noise = builder.AddNamedSystem(
        "sensor_noise", RandomSource(RandomDistribution.kGaussian, noise_size(joints), period)
    )
    sampler = builder.AddNamedSystem(
        "sampler", SensorSystem(config, joints, period, period - step / 4, trim_state)
    )
    builder.ExportInput(sampler.GetInputPort("true_state"), "true_state")
    builder.Connect(sensor_noise.get_output_port(), sampler.GetInputPort("noise"))
    _connect_late_state(builder, sampler, scenario, trim_state)
    is_exact_now = is_exact(config) and scenario.filter.delay_s == 0
    state_filter = builder.AddNamedSystem(
        "state_filter",
        StateFilterSystem(
            StateFilter.make(scenario.filter, period),
            SampleCheck.make(scenario.filter, config, period),
            scenario.filter.kind == "none" or is_exact_now,
            trim_state,
            trim_acceleration,
        ),
    )
    sample, stamps = sampler.GetOutputPort("state"), sampler.GetOutputPort("stamps")
    for i, fault in enumerate(scenario.faults):
        if isinstance(fault, SampleFault):
            faulty = builder.AddNamedSystem(
                f"{fault.kind}_{i}",
                SampleFaultSystem(fault, scenario.settle_s, period, trim_state),
            )
            builder.Connect(sample, faulty.GetInputPort("sample"))
            builder.Connect(stamps, faulty.GetInputPort("stamps"))
            sample, stamps = faulty.GetOutputPort("sample"), faulty.GetOutputPort("stamps")
    builder.Connect(sample, state_filter.GetInputPort("sample"))
    builder.Connect(stamps, state_filter.GetInputPort("stamps"))
    for port in ("acceleration", "reaction", "joint_setpoint"):
        builder.ExportInput(state_filter.GetInputPort(port), port)
    builder.ExportOutput(sample, "sample")
    for port in ("state", "external_acceleration", "sample_health"):
        builder.ExportOutput(state_filter.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("sensors")
    return diagram


def _connect_late_state(
    builder: DiagramBuilder, sampler: System, scenario: Scenario, trim_state: np.ndarray
) -> None:
    """Connects the true state to the sampler's `late_state`, through a delay if there is one."""
    step = scenario.rates.plant_step_s
    steps = round(scenario.sensors.base_delay_s / step)
    if not steps:
        builder.ConnectInput("true_state", sampler.GetInputPort("late_state"))
        return
    # The deviation from trim is delayed, since a delay's initial values are zeros.
    identity = np.eye(len(trim_state))
    deviation = builder.AddNamedSystem("deviation", AffineSystem(D=identity, y0=-trim_state))
    # Its update stores the state before the update, which is one step of the delay.
    delay = builder.AddNamedSystem(
        "base_delay", DiscreteTimeDelay(step, steps - 1, len(trim_state))
    )
    late_state = builder.AddNamedSystem("late_state", AffineSystem(D=identity, y0=trim_state))
    builder.Connect(deviation.get_output_port(), delay.get_input_port())
    builder.Connect(delay.get_output_port(), late_state.get_input_port())
    builder.Connect(late_state.get_output_port(), sampler.GetInputPort("late_state"))
    builder.ConnectInput("true_state", deviation.get_input_port())

"""The sensors as a diagram: samples of the state, their noise, and what is late about them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import AffineSystem, DiscreteTimeDelay, RandomSource

from aerodrake.model.sensing.sample import noise_size
from aerodrake.model.sensing.sample_check import SampleCheck
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import AnyFault, Filter, Rates, SampleFault, Sensors
from aerodrake.systems.faults.samples import SampleFaultSystem
from aerodrake.systems.sensors import SensorSystem, is_exact
from aerodrake.systems.state_filter import StateFilterSystem
from aerodrake.wiring.replacements import Replacements


def make_sensors(
    config: Sensors,
    state_filter: Filter,
    rates: Rates,
    trim_state: np.ndarray,
    trim_acceleration: np.ndarray,
    faults: Sequence[AnyFault] = (),
    settle_s: float = 0.0,
    replacements: Replacements | None = None,
) -> Diagram:
    """The state for all who look at the vehicle: exact and at once, unless the scenario says more.

    A sample is taken a quarter of a plant step before each multiple of the
    period. The plant's state is that of the multiple itself by then; and
    whatever is due there sees the sample, whichever kind of update it has.

    Inputs: `true_state` (13 + 2 n); `acceleration` (6) and `reaction` (3) of the flight
    controller and `joint_setpoint` (3 n), for the filter.
    Outputs: `sample` (13 + 2 n), the last one as it arrives, and `state` (13 + 2 n), what
    the filter makes of it, `trim_state` before the first; `external_acceleration` (3);
    `sample_health` (6), what it believes of the sample.

    Args:
        config: Noise and delay.
        state_filter: Of the samples.
        rates: Of samples, and of the plant, whose steps the delay counts.
        trim_state: (13 + 2 n,) the state before time 0.
        trim_acceleration: (6,) as the flight controller believes then.
        faults: Those of samples among them strike one after another, in their order.
        settle_s: Reference time 0.
        replacements: Of systems in it.
    """
    joints = len(split_state(trim_state).q)
    period, step = rates.sensor_period_s, rates.plant_step_s
    builder = (replacements or Replacements()).builder()
    sensor_noise = builder.AddNamedSystem(
        "sensor_noise", RandomSource(RandomDistribution.kGaussian, noise_size(joints), period)
    )
    sampler = builder.AddNamedSystem(
        "sampler", SensorSystem(config, joints, period, period - step / 4, trim_state)
    )
    builder.ExportInput(sampler.GetInputPort("true_state"), "true_state")
    builder.Connect(sensor_noise.get_output_port(), sampler.GetInputPort("noise"))
    steps = round(config.base_delay_s / step)
    if steps:
        # What is delayed is the deviation from trim, since a delay begins with zeros.
        same = np.eye(len(trim_state))
        deviation = builder.AddNamedSystem("deviation", AffineSystem(D=same, y0=-trim_state))
        # What it holds after an update is the state before it, which is one step's delay.
        delay = builder.AddNamedSystem(
            "base_delay", DiscreteTimeDelay(step, steps - 1, len(trim_state))
        )
        late_state = builder.AddNamedSystem("late_state", AffineSystem(D=same, y0=trim_state))
        builder.Connect(deviation.get_output_port(), delay.get_input_port())
        builder.Connect(delay.get_output_port(), late_state.get_input_port())
        builder.Connect(late_state.get_output_port(), sampler.GetInputPort("late_state"))
        builder.ConnectInput("true_state", deviation.get_input_port())
    else:
        builder.ConnectInput("true_state", sampler.GetInputPort("late_state"))
    is_exact_now = is_exact(config) and state_filter.delay_s == 0
    filtered = builder.AddNamedSystem(
        "state_filter",
        StateFilterSystem(
            StateFilter.make(state_filter, period),
            SampleCheck.make(state_filter, config, period),
            state_filter.kind == "none" or is_exact_now,
            joints,
            trim_state,
            trim_acceleration,
        ),
    )
    sample, stamps = sampler.GetOutputPort("state"), sampler.GetOutputPort("stamps")
    for i, fault in enumerate(faults):
        if isinstance(fault, SampleFault):
            struck = builder.AddNamedSystem(
                f"{fault.kind}_{i}", SampleFaultSystem(fault, settle_s, period, trim_state)
            )
            builder.Connect(sample, struck.GetInputPort("sample"))
            builder.Connect(stamps, struck.GetInputPort("stamps"))
            sample, stamps = struck.GetOutputPort("sample"), struck.GetOutputPort("stamps")
    builder.Connect(sample, filtered.GetInputPort("sample"))
    builder.Connect(stamps, filtered.GetInputPort("stamps"))
    for port in ("acceleration", "reaction", "joint_setpoint"):
        builder.ExportInput(filtered.GetInputPort(port), port)
    builder.ExportOutput(sample, "sample")
    for port in ("state", "external_acceleration", "sample_health"):
        builder.ExportOutput(filtered.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("sensors")
    return diagram

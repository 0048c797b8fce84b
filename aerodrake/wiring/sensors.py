"""Sensors as a diagram: samples of the state, noise, delay, faults, and the state filter."""

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import AffineSystem, DiscreteTimeDelay, RandomSource

from aerodrake.model.sensing.sample import noise_size
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import SampleFault, Scenario
from aerodrake.support.arguments import StateVector, Vector6, checked
from aerodrake.systems.faults.samples import SampleFaultSystem
from aerodrake.systems.sensors import SensorSystem, is_exact
from aerodrake.systems.state_filter import StateFilterSystem
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs, shared_input

WIRING = Wiring(
    connections=(
        ("sensor_noise", "output", "sampler", "noise"),
        ("sampler", "state", "state_filter", "sample"),
        ("sampler", "stamps", "state_filter", "stamps"),
    ),
    inputs=(
        ("true_state", "sampler", "true_state"),
        *shared_input("acceleration", "state_filter"),
        *shared_input("reaction", "state_filter"),
        *shared_input("joint_setpoint", "state_filter"),
    ),
    outputs=(
        ("sampler", "state", "sample"),
        *outputs("state_filter", "state", "external_acceleration", "sample_health"),
        *outputs("state_filter", "joint_oscillation", "position_offset"),
    ),
)
PROMPT = Wiring(inputs=(("true_state", "sampler", "late_state"),))
DELAYED = Wiring(
    connections=(
        ("deviation", "y0", "base_delay", "u"),
        ("base_delay", "delayed_u", "late_state", "u0"),
        ("late_state", "y0", "sampler", "late_state"),
    ),
    inputs=(("true_state", "deviation", "u0"),),
)


@checked
def make_sensors(
    scenario: Scenario,
    trim_state: StateVector,
    trim_acceleration: Vector6,
    replacements: Replacements | None = None,
) -> Diagram:
    """Makes the sensors: samples of the state, and an estimate of the present state.

    By default samples are exact and without delay. The first sample is that of the state in which
    the simulation starts. A sample is taken a quarter of a plant step
    before each multiple of the period, when the plant already has its state of that instant.
    All events at the instant use the sample, discrete and unrestricted ones alike.

    Inputs: `true_state` (13 + 2 n), a `VehicleState`; `acceleration` (6), `reaction` (3) and
    `joint_setpoint` (3 n) of the state filter.
    Outputs: `sample` (13 + 2 n), the last one as it arrives; `state` (13 + 2 n), `trim_state`
    before the first sample, `external_acceleration` (3), `sample_health` (6), `joint_oscillation`
    (n) and `position_offset` (3) of the filter.

    Args:
        scenario: Noise, delay, filter and rates; faults of samples, applied in the listed order.
        trim_state: (13 + 2 n,) the state before the simulation starts.
        trim_acceleration: (6,) acceleration that the flight controller models in trim.
        replacements: Replacements of its systems; None for none.
    """
    joints, config = len(split_state(trim_state).q), scenario.sensors
    period, step = scenario.rates.sensor_period_s, scenario.rates.plant_step_s
    builder = (replacements or Replacements()).builder()
    builder.AddNamedSystem(
        "sensor_noise", RandomSource(RandomDistribution.kGaussian, noise_size(joints), period)
    )
    sampler = SensorSystem(config, joints, period, period - step / 4, trim_state)
    builder.AddNamedSystem("sampler", sampler)
    delay_steps = round(config.base_delay_s / step)
    if delay_steps:
        # The deviation from trim is delayed, since a delay's initial values are zeros.
        size, identity = len(trim_state), np.eye(len(trim_state))
        builder.AddNamedSystem("deviation", AffineSystem(D=identity, y0=-trim_state))
        # Its update stores the state before the update, which is one step of the delay.
        builder.AddNamedSystem("base_delay", DiscreteTimeDelay(step, delay_steps - 1, size))
        builder.AddNamedSystem("late_state", AffineSystem(D=identity, y0=trim_state))
    equations = StateFilter.make(scenario.filter, config, period)
    is_exact_now = is_exact(config) and scenario.filter.delay_s == 0
    passes = scenario.filter.kind == "none" or is_exact_now
    state_filter = StateFilterSystem(equations, passes, trim_state, trim_acceleration)
    builder.AddNamedSystem("state_filter", state_filter)
    wiring = WIRING + (DELAYED if delay_steps else PROMPT)
    source, port = "sampler", "state"
    for i, fault in enumerate(scenario.faults):
        if isinstance(fault, SampleFault):
            name = f"{fault.kind}_{i}"
            faulty = SampleFaultSystem(fault, scenario.settle_s, period, len(trim_state))
            builder.AddNamedSystem(name, faulty)
            wiring = wiring.insert(name, (source, port), "sample", "sample")
            wiring = wiring.insert(name, (source, "stamps"), "stamps", "stamps")
            source, port = name, "sample"
    return wiring.build(builder, "sensors")

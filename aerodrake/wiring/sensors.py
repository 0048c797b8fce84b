"""Sensors as a diagram: samples of the state, noise, delay, flaws, faults, and the state filter.

`RATES` lists the periodic events of the systems that only some flaws need. If a flaw gives a sensor
a period of its own, it is also that of its events in `sampler`. `sensor_noise`, `sensor_draws` and
`inertial_noise` then have the greatest common divisor of the periods of the sensors they serve.
"""

import math
from collections.abc import Iterable

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import RandomSource

from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import GROUPS, INERTIAL_NOISE, noise_size
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import SampleFault, Scenario, Sensors
from aerodrake.support.arguments import StateVector, Vector6, checked
from aerodrake.support.errors import sourced
from aerodrake.systems.accelerometer import AccelerometerSystem
from aerodrake.systems.delay import make_delay
from aerodrake.systems.faults.samples import SampleFaultSystem
from aerodrake.systems.sensors import SensorSystem, is_exact
from aerodrake.systems.state_filter import StateFilterSystem
from aerodrake.systems.state_history import StateHistory
from aerodrake.systems.tool_sensor import ToolSensorSystem
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Rate, Wiring, outputs, shared_input

RATES = (
    Rate(("state_history",), "rates.plant_step_s"),
    Rate(("accelerometer",), "sensors.accelerometer.period_s", offset_steps=-1 / 4),
    Rate(("tool_sensor",), "sensors.tool.period_s", offset_steps=-1 / 4),
    Rate(("tool_noise",), "sensors.tool.period_s", kind="unrestricted"),
)
"""Periodic updates of the systems of flaws; periods are dotted keys of a scenario."""

INERTIAL = ("attitude", "accelerometer")
"""Sensors that `inertial_noise` serves."""

WIRING = Wiring(
    connections=(
        ("sensor_noise", "output", "sampler", "noise"),
        ("sampler", "state", "state_filter", "sample"),
        ("sampler", "stamps", "state_filter", "stamps"),
    ),
    inputs=(
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
PAST = Wiring(
    connections=(
        ("sensor_draws", "output", "state_history", "draws"),
        ("sensor_draws", "output", "sampler", "draws"),
        ("state_history", "sampled_state", "sampler", "true_state"),
        ("state_history", "sampled_state", "sampler", "late_state"),
    ),
    inputs=shared_input("true_state", "state_history"),
)
DRIFT = Wiring(connections=(("inertial_noise", "output", "sampler", "inertial_noise"),))
ACCELEROMETER = Wiring(
    connections=(
        ("sensor_draws", "output", "accelerometer", "draws"),
        ("inertial_noise", "output", "accelerometer", "noise"),
        ("state_history", "accelerometer_states", "accelerometer", "states"),
    ),
    outputs=outputs("accelerometer", "specific_force", "specific_force_stamp"),
)
FUSED = Wiring(
    connections=tuple(
        ("accelerometer", port, "state_filter", port)
        for port in ("specific_force", "specific_force_stamp")
    )
)
TOOL = Wiring(
    connections=(
        ("sensor_draws", "output", "tool_sensor", "draws"),
        ("tool_noise", "output", "tool_sensor", "noise"),
        ("state_history", "tool_state", "tool_sensor", "state"),
    ),
    outputs=outputs("tool_sensor", "tool_position", "tool_stamp"),
)


@checked
def make_sensors(
    scenario: Scenario,
    trim_state: StateVector,
    trim_acceleration: Vector6,
    replacements: Replacements | None = None,
    vehicle: VehicleModel | None = None,
    has_encoder_state: bool = False,
) -> Diagram:
    """Makes the sensors: samples of the state, and an estimate of the present state.

    By default samples are exact and without delay. The first sample is that of the state in which
    the simulation starts. A sample is taken a quarter of a plant step
    before each multiple of the period, when the plant already has its state of that instant.
    All events at the instant use the sample, discrete and unrestricted ones alike.

    Inputs: `true_state` (13 + 2 n), a `VehicleState`; `acceleration` (6), `reaction` (3) and
    `joint_setpoint` (3 n) of the state filter; and `encoder_state` (13 + 2 n) if wanted.
    Outputs: `sample` (13 + 2 n), the last one as it arrives; `state` (13 + 2 n), `trim_state`
    before the first sample, `external_acceleration` (3), `sample_health` (6), `joint_oscillation`
    (n) and `position_offset` (3) of the filter. With an accelerometer: `specific_force` (3) m/s^2
    and its stamp `specific_force_stamp` (1) s; with a tool sensor `tool_position` (3) m and
    `tool_stamp` (1) s.

    Args:
        scenario: Noise, delay, flaws, filter and rates; faults of samples, applied in the listed
            order.
        trim_state: (13 + 2 n,) the state before the simulation starts.
        trim_acceleration: (6,) acceleration that the flight controller models in trim.
        replacements: Replacements of its systems; None for none.
        vehicle: The scenario's vehicle, for the tool sensor, if it is loaded already.
        has_encoder_state: True for an input `encoder_state`: the true state with the joints that
            the encoders measure, such as the angles of motors. Without it that is `true_state`.

    Raises:
        ScenarioError: if `sensors.joints.zero_rad` does not fit the joints.
    """
    joints, config = len(split_state(trim_state).q), scenario.sensors
    period, step = scenario.rates.sensor_period_s, scenario.rates.plant_step_s
    builder = (replacements or Replacements()).builder()
    noise = RandomSource(
        RandomDistribution.kGaussian, noise_size(joints), _common_period(scenario, GROUPS)
    )
    builder.AddNamedSystem("sensor_noise", noise)
    delivery = Delivery.make(config, step)
    has_history = needs_history(config)
    late = delivery if has_history else None
    with sourced(scenario.source):
        sampler = SensorSystem(config, joints, period, period - step / 4, trim_state, late)
    builder.AddNamedSystem("sampler", sampler)
    measured = ("state_history", "encoder_state") if has_history else ("sampler", "true_state")
    encoders = "encoder_state" if has_encoder_state else "true_state"
    wiring = WIRING + Wiring(inputs=((encoders, *measured),))
    if not has_history:
        wiring += _add_delay(builder, scenario, trim_state)
    equations = StateFilter.make(scenario.filter, config, period)
    is_exact_now = is_exact(config) and scenario.filter.delay_s == 0
    passes = scenario.filter.kind == "none" or is_exact_now
    state_filter = StateFilterSystem(equations, passes, trim_state, trim_acceleration)
    builder.AddNamedSystem("state_filter", state_filter)
    if has_history:
        wiring += _add_history(builder, scenario, delivery, trim_state)
    if config.accelerometer.period_s > 0:
        wiring += _add_accelerometer(builder, scenario, delivery, trim_state)
    if config.attitude.rate_drift_rad_s2 > 0:
        wiring += DRIFT
    if config.accelerometer.period_s > 0 or config.attitude.rate_drift_rad_s2 > 0:
        draws = RandomDistribution.kGaussian, INERTIAL_NOISE, _common_period(scenario, INERTIAL)
        builder.AddNamedSystem("inertial_noise", RandomSource(*draws))
    if config.tool.period_s > 0:
        plant = (vehicle or VehicleModel.load(scenario)).plant
        tool = ToolSensorSystem(
            config.tool, delivery, plant, config.tool.period_s - step / 4, trim_state
        )
        builder.AddNamedSystem("tool_sensor", tool)
        noise = RandomSource(RandomDistribution.kGaussian, 3, config.tool.period_s)
        builder.AddNamedSystem("tool_noise", noise)
        wiring += TOOL
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


def needs_history(config: Sensors) -> bool:
    """Returns True if a sensor needs states of several instants."""
    each = config.each.values()
    is_irregular = any(sensor.loss > 0 or max(sensor.latency_s) > 0 for sensor in each)
    return is_irregular or config.accelerometer.period_s > 0 or config.tool.period_s > 0


def _add_delay(builder: DiagramBuilder, scenario: Scenario, trim_state: np.ndarray) -> Wiring:
    """Adds the known delay of the base, the same for all samples."""
    step = scenario.rates.plant_step_s
    delay_steps = round(scenario.sensors.base_delay_s / step)
    if not delay_steps:
        return PROMPT
    deviation, delay, late = make_delay(trim_state, delay_steps, step)
    builder.AddNamedSystem("deviation", deviation)
    builder.AddNamedSystem("base_delay", delay)
    builder.AddNamedSystem("late_state", late)
    return DELAYED


def _add_history(
    builder: DiagramBuilder,
    scenario: Scenario,
    delivery: Delivery,
    trim_state: np.ndarray,
) -> Wiring:
    """Adds past states, and the draws of their latencies."""
    period_steps = round(scenario.sensors.accelerometer.period_s / delivery.step)
    builder.AddNamedSystem("state_history", StateHistory(delivery, period_steps, trim_state))
    draws = RandomSource(
        RandomDistribution.kUniform, DRAWS, _common_period(scenario, scenario.sensors.each)
    )
    builder.AddNamedSystem("sensor_draws", draws)
    return PAST


def _add_accelerometer(
    builder: DiagramBuilder, scenario: Scenario, delivery: Delivery, trim_state: np.ndarray
) -> Wiring:
    """Adds the accelerometer, whose outputs are means over a period of the sensors."""
    config, rates = scenario.sensors.accelerometer, scenario.rates
    samples = max(1, round(rates.sensor_period_s / config.period_s))
    offset = config.period_s - rates.plant_step_s / 4
    accelerometer = AccelerometerSystem(config, delivery, samples, offset, trim_state)
    builder.AddNamedSystem("accelerometer", accelerometer)
    is_used = scenario.filter.accelerometer_noise_m_s2 > 0
    return ACCELEROMETER + FUSED if is_used else ACCELEROMETER


def _common_period(scenario: Scenario, names: Iterable[str]) -> float:
    """Returns the greatest common divisor in s of the periods of some sensors and `rates`' own."""
    rates = scenario.rates
    periods = [period for name in names if (period := scenario.sensors.each[name].period_s)]
    steps = [round(period / rates.plant_step_s) for period in (rates.sensor_period_s, *periods)]
    divisor = math.gcd(*steps)
    return rates.sensor_period_s if divisor == steps[0] else divisor * rates.plant_step_s

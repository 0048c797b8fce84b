"""State filter system: exact, delayed and missing samples, and estimates in flight."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial, Trajectory
from scipy.interpolate import PPoly
from scipy.spatial.transform import Rotation

from aerodrake.flight.excitation import excite, make_open_loop
from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.sensing.sample import GROUPS, group_columns
from aerodrake.model.sensing.sample_health import Verdict, split_health
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Filter, Rotor, SampleNan, Scenario, Sensors, Wind
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_context
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.state_filter import StateFilterSystem
from aerodrake.wiring.sensors import make_sensors

JOINTS = 6
SIZE = VehicleState.size(JOINTS)
PERIOD = 0.01
NOISY = Sensors(position_noise_m=0.002, attitude_noise_rad=0.003, joint_noise_rad=0.001)
TRIM = np.concatenate([[1, 0, 0, 0, 0.3, -0.2, 1.5], np.linspace(-1, 1, JOINTS), np.zeros(12)])


def make_filter(config: Filter, trim_acceleration: np.ndarray) -> StateFilterSystem:
    """Returns a state filter that never passes samples."""
    equations = StateFilter.make(config, Sensors(), PERIOD)
    return StateFilterSystem(equations, False, TRIM, trim_acceleration)


def resting(vehicle: VehicleModel, duration: float) -> tuple[Trajectory, Trajectory]:
    """Returns motions of base and joints that stay in trim."""
    return tuple(
        PiecewisePolynomial.ZeroOrderHold([0, duration], np.column_stack([x, x]))
        for x in (vehicle.p_B, vehicle.working)
    )


@settings(max_examples=10)
@given(steps=arrays(float, (3, SIZE), elements=st.floats(1e-4, 4e-4)))
@pytest.mark.parametrize(
    ("sensors", "config", "passes"),
    [
        (Sensors(), Filter(), True),
        (Sensors(base_delay_s=0.004), Filter(), True),
        (NOISY, Filter(kind="none"), True),
        (Sensors(base_delay_s=0.01), Filter(kind="none", delay_s=0.01), True),
        (NOISY, Filter(), False),
        (Sensors(base_delay_s=0.01), Filter(delay_s=0.01), False),
    ],
)
def test_samples_that_need_no_filter_pass_bit_for_bit(sensors, config, passes, steps):
    scenario = Scenario(sensors=sensors, filter=config)
    diagram = make_sensors(scenario, TRIM, np.zeros(6))
    context = make_context(diagram, 0)
    diagram.GetInputPort("acceleration").FixValue(context, np.full(6, 1e-3))
    diagram.GetInputPort("reaction").FixValue(context, np.ones(3))
    diagram.GetInputPort("joint_setpoint").FixValue(context, np.ones(3 * JOINTS))
    diagram.GetInputPort("true_state").FixValue(context, TRIM)
    simulator = Simulator(diagram, context)
    simulator.AdvanceTo(PERIOD / 2)
    outputs = []
    for k, x in enumerate(TRIM + np.cumsum(steps, axis=0)):
        diagram.GetInputPort("true_state").FixValue(context, x)
        simulator.AdvanceTo((k + 1.5) * PERIOD)
        outputs.append([diagram.GetOutputPort(p).Eval(context).copy() for p in ("state", "sample")])
    state, sample = np.swapaxes(outputs, 0, 1)
    assert not np.array_equal(sample[0], TRIM)
    assert np.array_equal(state, sample) == passes


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_known_motion_is_estimated_in_the_present_at_any_delay(steps):
    """Accelerations are as modelled, but for a constant disturbance that the filter starts with."""
    rows = 20
    trim_acceleration = np.array([0.3, -0.2, 0.1, 0, 0, 0.7])
    e, a = np.array([0.0, 0, 1]), np.random.default_rng(0).normal(scale=5, size=(rows, 4))
    # At rest until time 0; a[k] is constant from sample k to the next.
    times = PERIOD * np.arange(rows + 1)
    speed = PPoly(a[None], times).antiderivative()
    distance = speed.antiderivative()

    def truth(k: int) -> np.ndarray:
        v, p = (speed(times[k]), distance(times[k])) if k > 0 else np.zeros((2, 4))
        state = split_state(TRIM)
        return state._replace(
            quaternion=Rotation.from_rotvec(p[3] * e).as_quat(scalar_first=True),
            p_B=state.p_B + p[:3],
            omega_W=v[3] * e,
            v_B=v[:3],
        ).to_vector()

    system = make_filter(Filter(delay_s=steps * PERIOD), trim_acceleration)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    for k in range(rows):
        modelled = np.concatenate([a[k - 1][:3], a[k - 1][3] * e]) if k > 0 else np.zeros(6)
        system.GetInputPort("sample").FixValue(context, truth(k - steps))
        system.GetInputPort("stamps").FixValue(context, np.full(3, k * PERIOD))
        system.GetInputPort("joint_setpoint").FixValue(context, np.zeros(3 * JOINTS))
        system.GetInputPort("acceleration").FixValue(context, modelled + trim_acceleration)
        system.GetInputPort("reaction").FixValue(context, [0.0, 0.0, float(k)])
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        state = system.GetOutputPort("state").Eval(context)
        np.testing.assert_allclose(state, truth(k), rtol=0, atol=1e-12, err_msg=f"{k}")
        external = system.GetOutputPort("external_acceleration").Eval(context)
        np.testing.assert_allclose(external, -trim_acceleration[:3] - [0, 0, k], atol=1e-9)


def test_a_consumer_of_the_same_instant_sees_the_new_state():
    """Drake's sample-and-hold adds no delay after the filter, and a period after another."""
    builder = DiagramBuilder()
    ramp = PiecewisePolynomial.FirstOrderHold([0, 1], np.column_stack([TRIM, TRIM + 0.1]))
    sample = builder.AddSystem(TrajectorySource(ramp))
    system = builder.AddSystem(make_filter(Filter(), np.zeros(6)))
    first, second = (builder.AddSystem(ZeroOrderHold(PERIOD, SIZE)) for _ in range(2))
    builder.Connect(sample.get_output_port(), system.GetInputPort("sample"))
    clock = builder.AddSystem(
        TrajectorySource(PiecewisePolynomial.FirstOrderHold([0, 1], [[0, 1]] * 3))
    )
    builder.Connect(clock.get_output_port(), system.GetInputPort("stamps"))
    for port, size in (("acceleration", 6), ("reaction", 3), ("joint_setpoint", 3 * JOINTS)):
        source = builder.AddSystem(ConstantVectorSource(np.zeros(size)))
        builder.Connect(source.get_output_port(), system.GetInputPort(port))
    builder.Connect(system.GetOutputPort("state"), first.get_input_port())
    builder.Connect(first.get_output_port(), second.get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    rows = []
    for k in range(10):
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        context = simulator.get_context()
        rows.append(
            [s.get_output_port(0).Eval(s.GetMyContextFromRoot(context)) for s in (system, first)]
            + [second.get_output_port().Eval(second.GetMyContextFromRoot(context))]
        )
    states, sampled, sampled_again = np.swapaxes(rows, 0, 1)
    assert len(np.unique(states, axis=0)) == len(states)
    np.testing.assert_array_equal(sampled, states)
    np.testing.assert_array_equal(sampled_again[1:], states[:-1])


@pytest.mark.parametrize("config", [Filter(), Filter(kind="none"), Filter(delay_s=0.01)])
@pytest.mark.parametrize("group", GROUPS)
def test_health_has_the_age_and_verdict_of_a_missing_group(config, group):
    fault = SampleNan(group=group, start_s=0.05, duration_s=0.1)
    scenario = Scenario(sensors=NOISY, filter=config, faults=(fault,), settle_s=0.0)
    diagram = make_sensors(scenario, TRIM, np.zeros(6))
    context = make_context(diagram, 0)
    for port, size in (("acceleration", 6), ("reaction", 3)):
        diagram.GetInputPort(port).FixValue(context, np.zeros(size))
    setpoint = np.append(split_state(TRIM).q, np.zeros(2 * JOINTS))
    diagram.GetInputPort("joint_setpoint").FixValue(context, setpoint)
    diagram.GetInputPort("true_state").FixValue(context, TRIM)
    simulator = Simulator(diagram, context)
    is_faulty = np.array([g == group for g in GROUPS])
    broken = np.isin(np.arange(SIZE), group_columns(group, JOINTS))
    for k in range(25):
        simulator.AdvanceTo((k + 0.5) * PERIOD)
        health, state, sample = (
            diagram.GetOutputPort(port).Eval(context)
            for port in ("sample_health", "state", "sample")
        )
        missing = max(0, k - 4) * (k < 15)
        ages, verdicts = split_health(health)
        np.testing.assert_allclose(ages, missing * PERIOD * is_faulty, atol=1e-12)
        np.testing.assert_array_equal(verdicts, Verdict.NOT_FINITE * is_faulty * (missing > 0))
        assert np.isfinite(state).all()
        np.testing.assert_array_equal(np.isnan(sample), broken & (missing > 0))
        if config.kind == "none":
            accepted = ~np.isnan(sample)
            np.testing.assert_array_equal(state[accepted], sample[accepted])


def test_no_feedthrough():
    assert not make_filter(Filter(delay_s=0.02), np.zeros(6)).HasAnyDirectFeedthrough()


@pytest.mark.parametrize("feedforward", ["whole_body", "none"])
def test_trim_is_an_equilibrium_from_the_first_sample_on(scenario, vehicle, feedforward):
    delayed = replace(
        scenario,
        sensors=Sensors(base_delay_s=0.02),
        filter=Filter(delay_s=0.02),
        flight=replace(scenario.flight, feedforward=feedforward),
    )
    flown = excite(delayed, *resting(vehicle, 0.3))
    np.testing.assert_allclose(flown.state - vehicle.trim_state, 0, atol=1e-11)
    np.testing.assert_allclose(flown.external_acceleration, 0, atol=1e-11)


def test_a_clone_continues_as_the_original(scenario, vehicle):
    noisy = replace(
        scenario, sensors=replace(NOISY, base_delay_s=0.02), filter=Filter(delay_s=0.02)
    )
    diagram = make_open_loop(noisy, *resting(vehicle, 1.0))
    simulator = Simulator(diagram, make_context(diagram, 0))
    simulator.AdvanceTo(0.1034)
    clone = simulator.get_context().Clone()
    ports = [diagram.GetOutputPort(p) for p in ("state", "external_acceleration")]
    before = [port.Eval(clone) for port in ports]
    simulator.AdvanceTo(0.2034)
    ends = [port.Eval(simulator.get_context()) for port in ports]
    for port, was, end in zip(ports, before, ends, strict=True):
        np.testing.assert_array_equal(port.Eval(clone), was)
        assert np.all(was[:3] != end[:3])
    Simulator(diagram, clone).AdvanceTo(0.2034)
    for port, end in zip(ports, ends, strict=True):
        np.testing.assert_array_equal(port.Eval(clone), end)


@pytest.mark.parametrize("feedforward", ["whole_body", "none"])
@pytest.mark.parametrize("sensors", [Sensors(), NOISY])
def test_steady_wind_is_estimated(scenario, vehicle, feedforward, sensors):
    """Its force over the mass, averaged over a second, when the base is at rest again.

    The rotors lag equally up and down: rotors that rise faster than they fall give more thrust
    than noisy commands ask for, which would be estimated as well.
    """
    wind = Wind(velocity_m_s=(4.0, -2.0, 1.0))
    windy = replace(
        scenario,
        wind=wind,
        sensors=sensors,
        vehicle=replace(scenario.vehicle, rotor=Rotor(lag_up_s=0.02, lag_down_s=0.02)),
        flight=replace(scenario.flight, feedforward=feedforward),
    )
    flown = excite(windy, *resting(vehicle, 4.5))
    v = np.array(wind.velocity_m_s)
    drag = wind.quadratic_drag_n_s2_m2 * np.linalg.norm(v) + wind.linear_drag_n_s_m
    expected = drag * v / vehicle.mass
    estimated = flown.external_acceleration[flown.time_s > 3.5].mean(axis=0)
    assert np.linalg.norm(estimated - expected) < 0.02 * np.linalg.norm(expected)


def test_the_reaction_of_the_arm_is_modelled_with_the_command(scenario, vehicle):
    """Thrust compensates the vertical part at once; the base accelerates against the rest."""
    flight = replace(scenario.flight, feedforward="whole_body")
    controller = FlightController(flight, Rotor(), vehicle, PERIOD, 0.0)
    context = controller.CreateDefaultContext()
    arm = np.concatenate([vehicle.working, np.zeros(JOINTS), np.linspace(1, 6, JOINTS)])
    controller.GetInputPort("state").FixValue(context, vehicle.trim_state)
    controller.GetInputPort("base_setpoint").FixValue(context, [*vehicle.p_B, *np.zeros(6)])
    controller.GetInputPort("joint_setpoint").FixValue(context, arm)
    Simulator(controller, context).AdvanceTo(PERIOD / 2)
    reaction = controller.GetOutputPort("reaction").Eval(context)
    acceleration = controller.GetOutputPort("acceleration").Eval(context)[:3]
    assert np.all(np.abs(reaction) > 1e-3)
    np.testing.assert_allclose(acceleration, -reaction * [1, 1, 0], atol=1e-9)


@pytest.fixture(scope="module")
def realistic() -> FlightLog:
    """4 s of noise, delay, gusts and model mismatch."""
    return FlightSimulation(
        replace(load_scenario("clover_realistic"), settle_s=0.0, duration=4.0)
    ).fly()


@pytest.mark.parametrize(
    ("key", "ratio"),
    [
        ("p_B_m", 0.4),  # 0.28 when measured.
        ("v_B_m_s", 0.65),  # 0.49
        ("quaternion", 0.25),  # 0.15
        ("omega_W_rad_s", 0.8),  # 0.61
        ("q_rad", 0.4),  # 0.26
    ],
)
def test_an_estimate_is_closer_to_the_truth_than_its_sample(realistic, key, ratio):
    """In root mean square. A row logs the estimate before the update of its instant."""
    true = realistic[key]
    sampled = error(key, true[:-1], realistic[f"measured_{key}"][:-1])
    estimated = error(key, true[:-1], realistic[f"estimated_{key}"][1:])
    later = slice(50, None)
    assert np.mean(estimated[later] ** 2) < ratio**2 * np.mean(sampled[later] ** 2)


def error(key: str, true: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns the distances (T,), or the angles between quaternions."""
    if key != "quaternion":
        return np.linalg.norm(other - true, axis=1)
    R, other_R = (Rotation.from_quat(q, scalar_first=True) for q in (true, other))
    return (R.inv() * other_R).magnitude()

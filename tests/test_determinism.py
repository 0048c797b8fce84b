"""Flights of the same scenario are equal bit for bit."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

import aerodrake
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.scenario import Clover, Mismatch, Mpc, Payload, Residual, Scenario, Sensors, Wind
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from aerodrake.support.threads import single_thread
from tests.robots import multibody_plant


def noisy(seed: int = 7) -> Scenario:
    """Short, with noise, delay, gusts, learning, and a solver that iterates."""
    return Scenario(
        duration=0.8,
        settle_s=0.2,
        seed=seed,
        reference=Clover(start_s=0.3),
        mpc=Mpc(base_acceleration_m_s2=(0.2, 0.2, 0.2)),
        residual=Residual(mode="online", learning_rate=0.01, batch=5, gate_s=0.0),
        sensors=Sensors(
            position_noise_m=1e-3,
            velocity_noise_m_s=1e-2,
            attitude_noise_rad=1e-3,
            rate_noise_rad_s=1e-2,
            joint_noise_rad=1e-4,
            base_delay_s=0.003,
        ),
        wind=Wind(velocity_m_s=(0.5, 0.0, 0.0), gust_m_s=(0.2, 0.2, 0.2)),
        payload=Payload(mass_kg=0.1),
        mismatch=Mismatch(
            mass_scale=1.05, inertia_scale=0.9, rotor_lag_scale=1.2, thrust_scale=1.1
        ),
    )


def assert_same(signals, others) -> None:
    assert set(signals) == set(others)
    for key in set(signals) - {"tick_ms"}:
        np.testing.assert_array_equal(signals[key], others[key], err_msg=key)
    assert len(signals["tick_ms"]) == len(others["tick_ms"])


@pytest.fixture(scope="module")
def flight() -> FlightSimulation:
    return FlightSimulation(noisy())


@pytest.fixture(scope="module")
def signals(flight):
    return flight.fly().signals


def test_there_is_something_that_could_differ(signals):
    assert np.any(signals["measured_p_B_m"] != signals["p_B_m"])
    assert np.any(signals["delta_m_s2"] != 0)
    assert np.count_nonzero(signals["qp_status"]) > 10  # Programs with active bounds.
    assert np.ptp(signals["p_E_m"]) > 0
    assert len(np.unique(signals["wind_force_n"], axis=0)) == len(signals["time_s"])
    for key, signal in signals.items():
        assert np.all(np.isfinite(signal)), key


def test_flown_again(flight, signals):
    assert_same(flight.fly().signals, signals)


def test_flown_by_another_diagram(signals):
    """Built after others, some of which were flown: no state is shared between them."""
    FlightSimulation(noisy(seed=8)).fly()
    assert_same(FlightSimulation(noisy()).fly().signals, signals)


def test_flown_by_another_process(signals, tmp_path):
    """A process with another hash seed, which has built no other diagram."""
    path = tmp_path / "log.npz"
    code = (
        f"import sys; sys.path[:0] = {[str(Path(__file__).parent)]!r}\n"
        "from test_determinism import FlightSimulation, noisy\n"
        f"from pathlib import Path; FlightSimulation(noisy()).fly().save(Path({str(path)!r}))"
    )
    root = str(Path(aerodrake.__file__).parents[1])
    environment = os.environ | {"PYTHONHASHSEED": "123", "PYTHONPATH": root}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment, cwd=tmp_path)
    with np.load(path) as log:
        assert_same(signals, dict(log))


def test_another_seed_is_another_flight(signals):
    other = FlightSimulation(noisy(seed=8)).fly().signals
    for key in ("measured_p_B_m", "measured_q_rad", "p_B_m", "thrust_n", "p_E_m", "wind_force_n"):
        assert np.any(other[key] != signals[key]), key


@pytest.fixture(scope="module")
def closed_loop():
    return make_closed_loop(noisy())


def advance(diagram, context, *times) -> np.ndarray:
    """Returns state and outputs after advancing to each of `times`."""
    simulator = Simulator(diagram, context)
    simulator.Initialize()
    with single_thread():
        for time in times:
            simulator.AdvanceTo(time)
    return numbers(diagram, context)


def numbers(diagram, context) -> np.ndarray:
    """Returns all discrete state, and all vector outputs."""
    groups = context.get_discrete_state()
    state = [groups.value(i) for i in range(groups.num_groups())]
    ports = map(diagram.get_output_port, range(diagram.num_output_ports()))
    outputs = [p.Eval(context) for p in ports if p.get_name() != "body_poses"]
    return np.concatenate([np.ravel(value) for value in (*state, *outputs)])


@pytest.fixture
def context(closed_loop):
    context = make_context(closed_loop, 7)
    Simulator(closed_loop, context).AdvanceTo(0.405)
    return context


def test_a_clone_continues_as_the_original_does(closed_loop, context):
    clone = context.Clone()
    ahead = advance(closed_loop, context, 0.6)
    np.testing.assert_array_equal(advance(closed_loop, clone, 0.6), ahead)


def test_a_clone_is_independent(closed_loop, context):
    clone, third = context.Clone(), context.Clone()
    before = numbers(closed_loop, context)
    ahead = advance(closed_loop, clone, 0.6)
    np.testing.assert_array_equal(numbers(closed_loop, context), before)
    assert context.get_time() == 0.405

    # A change of one context does not change another.
    plant = multibody_plant(closed_loop)
    pushed = plant.GetMyMutableContextFromRoot(third)
    plant.SetPositions(pushed, plant.GetPositions(pushed) + 0.01 * (np.arange(13) == 4))
    assert np.any(advance(closed_loop, third, 0.6) != ahead)
    np.testing.assert_array_equal(advance(closed_loop, context, 0.6), ahead)


def test_the_lengths_of_steps_of_the_simulator_do_not_matter(closed_loop):
    whole = advance(closed_loop, make_context(closed_loop, 7), 0.5)
    chunks = np.sort(np.random.default_rng(0).uniform(0, 0.5, 40))
    ticks = np.arange(1, 25) * 0.02
    for times in (chunks, ticks):
        parts = advance(closed_loop, make_context(closed_loop, 7), *times, 0.5)
        np.testing.assert_array_equal(parts, whole)


def test_all_flaws_at_once_are_repeatable_and_cloneable():
    loop = make_closed_loop(load_scenario("clover_field_tool", {"settle_s": 0.0}))
    context = make_context(loop, 7)
    Simulator(loop, context).AdvanceTo(0.205)
    clone = context.Clone()
    ahead = advance(loop, context, 0.305)
    np.testing.assert_array_equal(advance(loop, clone, 0.305), ahead)
    np.testing.assert_array_equal(advance(loop, make_context(loop, 7), 0.205, 0.305), ahead)
    assert np.any(advance(loop, make_context(loop, 8), 0.305) != ahead)

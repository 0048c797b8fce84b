"""Linear loops against simulations of the same loop, other scenarios and flights."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.analysis.linear_loop import LinearLoop, Variation
from aerodrake.analysis.linearization import Linearizer
from aerodrake.analysis.margin_limits import stability_margins
from aerodrake.analysis.modes import find_modes
from aerodrake.analysis.quiet_loop import QuietLoop
from aerodrake.analysis.tool_responses import step_responses
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Filter, Flight, Mismatch, Rates, Scenario, Sensors
from aerodrake.station import make_closed_loop
from tests.arms import DESIGNS, arm_scenario

PERIOD = 10
"""Number of the period that is linearised."""


def quiet_in_hover(scenario: Scenario) -> QuietLoop:
    """Returns the loop at the start of a period, with the unconstrained MPC."""
    quiet = QuietLoop(scenario, 5.0)
    quiet.advance(quiet.start_s(PERIOD))
    quiet.is_constrained = False
    return quiet


def linear(scenario: Scenario) -> LinearLoop:
    return LinearLoop(Linearizer(quiet_in_hover(scenario), PERIOD).run())


def slow(eigenvalues: np.ndarray) -> np.ndarray:
    """Returns the eigenvalues that are well defined, those of deadbeat states not, in order."""
    chosen = eigenvalues[np.abs(eigenvalues) > 0.3]
    return chosen[np.lexsort((chosen.imag.round(6), chosen.real.round(6)))]


@pytest.fixture(scope="module")
def scenario(tmp_path_factory) -> Scenario:
    """An arm of two joints with the sensors' filter, and long steps of the plant."""
    arm = arm_scenario(DESIGNS["two"], tmp_path_factory.mktemp("two"))
    return replace(arm, rates=Rates(plant_step_s=0.005), filter=Filter(delay_s=0.01))


@pytest.fixture(scope="module")
def loop(scenario) -> LinearLoop:
    return linear(scenario)


def test_product_of_jacobians_is_that_of_the_whole_period(scenario, loop):
    quiet, system, coordinates = quiet_in_hover(scenario), loop.system, loop.period.coordinates
    start, names = quiet.snapshot(), list(coordinates.names)
    columns = [names.index(state) for state in system.states]
    for seed in range(3):
        direction = np.random.default_rng(seed).standard_normal(len(system.states))
        steps, after = np.zeros(len(names)), []
        for sign in (1, -1):
            steps[columns] = sign * 1e-6 * direction
            quiet.restore(start, quiet.start_s(PERIOD))
            values = quiet.context.get_mutable_discrete_state()
            for group, part in zip(coordinates.groups, coordinates.slices, strict=True):
                group.perturb(values, steps[part])
            quiet.advance(quiet.start_s(PERIOD + 1))
            after.append(quiet.snapshot())
        change = np.concatenate(
            [g.difference(*(v.value(g.index) for v in after)) for g in coordinates.groups]
        )
        np.testing.assert_allclose(change[columns] / 2e-6, system.A @ direction, atol=2e-4)


def test_delay_is_that_of_the_sensors(scenario, loop):
    late = linear(replace(scenario, sensors=Sensors(base_delay_s=0.035)))
    ours = np.linalg.eigvals(loop.matrices(Variation(delay_steps=7)).A)
    np.testing.assert_allclose(slow(ours), slow(late.system.eigenvalues), atol=1e-5)
    later = np.linalg.eigvals(late.matrices(Variation(delay_steps=2)).A)
    expected = np.linalg.eigvals(loop.matrices(Variation(delay_steps=9)).A)
    np.testing.assert_allclose(slow(later), slow(expected), atol=1e-5)


def test_rotor_gain_is_that_of_the_mismatch(scenario, loop):
    stronger = linear(replace(scenario, mismatch=Mismatch(thrust_scale=1.4)))
    ours = np.linalg.eigvals(loop.matrices(Variation(rotor_gain=1.4)).A)
    np.testing.assert_allclose(slow(ours), slow(stronger.system.eigenvalues), atol=1e-5)


def test_margins_are_the_first_unstable_values(loop):
    for margin in stability_margins(loop):
        for limit in filter(None, (margin.lower, margin.upper)):
            inside = limit.value * (0.998 if limit is margin.upper else 1.002)
            if margin.kind == "gain":
                at, before = (
                    np.abs(np.linalg.eigvals(loop.matrices(Variation(**{margin.name: g})).A)).max()
                    for g in (limit.value, inside)
                )
            else:
                steps = round(limit.value / 0.005)
                at, before = (
                    np.abs(np.linalg.eigvals(loop.matrices(Variation(delay_steps=d)).A)).max()
                    for d in (steps, steps - 1)
                )
            assert at > 1.0004 > before, margin
            assert limit.frequency_hz < 100.0


def test_step_response_is_that_of_a_simulation(scenario, loop):
    quiet = quiet_in_hover(scenario)
    kinematics = Kinematics(quiet.vehicle.plant)
    group = next(g for g in loop.period.coordinates.groups if g.system == "disturbance")
    force = 1e-3
    values = quiet.context.get_mutable_discrete_state()
    group.perturb(values, force * np.eye(6)[3])  # Torques come first.
    tool = []
    for k in range(20):
        quiet.advance(quiet.start_s(PERIOD + k))
        state = split_state(quiet.output("true_state"))
        tool.append(kinematics.end_effector(state).p_E)
    response = next(r for r in step_responses(loop.system) if r.input == "force_x")
    np.testing.assert_allclose(
        (np.array(tool) - tool[0]) / force, response.values[:20], atol=1e-4 * response.peak
    )


def test_unstable_mode_grows_as_in_a_flight(tmp_path):
    arm = arm_scenario(DESIGNS["long"], tmp_path)
    scenario = replace(
        arm,
        settle_s=5.0,
        rates=Rates(plant_step_s=0.0025),
        flight=Flight(feedforward="whole_body"),
    )
    mode = find_modes(linear(scenario))[0]
    assert not mode.is_stable
    assert {"roll", "joint_1"} & {participant.name for participant in mode.participants}

    diagram = make_closed_loop(scenario)
    context = diagram.CreateDefaultContext()
    simulator, dt = Simulator(diagram, context), scenario.rates.mpc_period_s
    rates = []
    while not rates or abs(rates[-1]) < 0.1:  # Grows from rounding errors.
        simulator.AdvanceTo((len(rates) + 0.9) * dt)
        rates.append(split_state(diagram.GetOutputPort("true_state").Eval(context)).omega_W[0])
    last = np.array(rates[-14:])
    # y[k+1] = 2 Re(z) y[k] - |z|^2 y[k-1] for one pair of eigenvalues.
    a, b = np.linalg.lstsq(np.column_stack([last[1:-1], last[:-2]]), last[2:], rcond=None)[0]
    z = np.roots([1.0, -a, -b])[0]
    assert np.log(abs(z)) / dt == pytest.approx(mode.growth_1_s, rel=0.2)
    assert abs(np.angle(z)) / (2 * np.pi * dt) == pytest.approx(mode.frequency_hz, rel=0.1)

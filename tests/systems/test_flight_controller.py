"""Flight controller by itself, and on the station's plant."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from aerodrake.model.vehicle.robot import add_robot
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.station import make_context, make_station
from aerodrake.systems.flight_controller import FlightController

PERIOD, OFFSET = 0.01, 0.001
FEEDFORWARDS = pytest.mark.parametrize("feedforward", ["torque", "whole_body", "none"])


def make_controller(scenario, vehicle, **flight) -> FlightController:
    config = replace(scenario.flight, **flight)
    return FlightController(config, scenario.vehicle.rotor, vehicle, PERIOD, OFFSET)


@pytest.fixture(scope="module")
def mixer(scenario, vehicle):
    """The mixer (4, k) from thrusts to the wrench on the base, from the rotors' positions."""
    x, y, _ = vehicle.rotors.p_B.T
    return np.array(
        [np.ones(4), y, -x, -scenario.vehicle.rotor.torque_ratio_m * np.array([1, -1, 1, -1])]
    )


@pytest.fixture(scope="module")
def centre(vehicle) -> np.ndarray:
    """Centre of mass (3,) m in trim, from the base's origin."""
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, vehicle.trim_state)
    return plant.CalcCenterOfMassPositionInWorld(context) - vehicle.p_B


def lever(vehicle, centre, feedforward: str, a_B) -> np.ndarray:
    """Returns the torque (3,) N m of the arm's weight; with feedforward, of its inertia as well."""
    modelled = np.asarray(a_B) if feedforward != "none" else np.zeros(3)
    return np.cross(centre, vehicle.mass * (modelled + [0, 0, GRAVITY]))


@pytest.fixture
def hover(vehicle) -> np.ndarray:
    return np.concatenate([vehicle.p_B, np.zeros(6)])


def tick(controller, context, state, setpoint) -> np.ndarray:
    """Returns the command (k,) N after an update."""
    controller.GetInputPort("state").FixValue(context, state)
    controller.GetInputPort("base_setpoint").FixValue(context, setpoint)
    # The arm's setpoint is its present configuration.
    q = split_state(state).q
    folded = np.concatenate([q, np.zeros(2 * len(q))])
    controller.GetInputPort("joint_setpoint").FixValue(context, folded)
    context.SetDiscreteState(controller.EvalUniquePeriodicDiscreteUpdate(context))
    return controller.GetOutputPort("thrust_command").Eval(context)


def first_command(controller, state, setpoint) -> np.ndarray:
    return tick(controller, controller.CreateDefaultContext(), state, setpoint)


def test_ports_rate_and_feedthrough(scenario, vehicle):
    controller = make_controller(scenario, vehicle)
    assert controller.GetInputPort("state").size() == VehicleState.size(vehicle.joints)
    assert controller.GetInputPort("base_setpoint").size() == 9
    assert controller.GetOutputPort("thrust_command").size() == len(vehicle.rotors.names)
    assert controller.GetOutputPort("disturbance").size() == 6
    assert controller.GetOutputPort("saturated").size() == 1
    assert not controller.HasAnyDirectFeedthrough()
    timing = controller.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, OFFSET)


@FEEDFORWARDS
@pytest.mark.parametrize("interface", ["trajectory", "position"])
def test_trim_is_an_equilibrium(scenario, vehicle, mixer, hover, interface, feedforward):
    controller = make_controller(
        scenario, vehicle, interface=interface, feedforward=feedforward, integral_gain=(1, 1, 1)
    )
    context = controller.CreateDefaultContext()
    trim = controller.GetOutputPort("thrust_command").Eval(context).copy()
    np.testing.assert_allclose(mixer @ trim, vehicle.trim_wrench, atol=1e-12)
    for _ in range(500):
        command = tick(controller, context, vehicle.trim_state, hover)
        np.testing.assert_allclose(command, trim, rtol=0, atol=1e-11)
        assert controller.GetOutputPort("saturated").Eval(context) == 0


@FEEDFORWARDS
def test_height_error_by_hand(scenario, vehicle, mixer, hover, centre, feedforward):
    """Thrust of m (g + k_p e), and no torque beyond that of the arm's weight."""
    controller = make_controller(
        scenario, vehicle, position_gain=(9, 9, 7), feedforward=feedforward
    )
    hover[2] += 0.2
    wrench = mixer @ first_command(controller, vehicle.trim_state, hover)
    torque = lever(vehicle, centre, feedforward, [0, 0, 7 * 0.2])
    expected = [vehicle.mass * (GRAVITY + 7 * 0.2), *torque]
    np.testing.assert_allclose(wrench, expected, atol=1e-10)


@FEEDFORWARDS
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("rate_filter_s", [0.0, 0.04])
def test_horizontal_error_by_hand(
    scenario, vehicle, mixer, hover, centre, axis, rate_filter_s, feedforward
):
    """The thrust axis turns towards the setpoint, and its filtered rate is fed forward."""
    controller = make_controller(
        scenario,
        vehicle,
        position_gain=(9, 9, 9),
        attitude_gain=(144, 144, 36),
        rate_gain=(24, 24, 12),
        rate_filter_s=rate_filter_s,
        feedforward=feedforward,
    )
    step = 1e-4
    hover[axis] += step
    angle = math.atan(9 * step / GRAVITY)
    turn = 144 * math.sin(angle) + 24 * angle / (PERIOD + rate_filter_s)
    torque = vehicle.inertia @ ([0, turn, 0] if axis == 0 else [-turn, 0, 0])
    torque = torque + lever(vehicle, centre, feedforward, 9 * step * np.eye(3)[axis])
    wrench = [vehicle.mass * GRAVITY, *torque]
    command = first_command(controller, vehicle.trim_state, hover)
    np.testing.assert_allclose(mixer @ command, wrench, rtol=1e-8, atol=1e-10)


def test_velocity_and_feedforward_by_hand(scenario, vehicle, mixer, hover):
    """Also with a moving base, whose velocity the law uses but the ESO does not yet estimate."""
    controller = make_controller(scenario, vehicle, velocity_gain=(5, 5, 6))
    hover[5], hover[8] = 0.3, 0.7
    state = vehicle.trim_state
    state[-vehicle.joints - 1] = 0.1
    wrench = mixer @ first_command(controller, state, hover)
    assert wrench[0] == pytest.approx(vehicle.mass * (GRAVITY + 6 * 0.2 + 0.7), rel=1e-12)


def test_the_position_interface_uses_p_d_alone(scenario, vehicle, hover):
    moving = hover + np.concatenate([np.zeros(3), np.full(6, 0.2)])
    for interface, is_used in (("position", False), ("trajectory", True)):
        controller = make_controller(scenario, vehicle, interface=interface)
        still = first_command(controller, vehicle.trim_state, hover)
        assert is_used == np.any(still != first_command(controller, vehicle.trim_state, moving))
        higher = first_command(controller, vehicle.trim_state, hover + np.eye(9)[2])
        assert np.all(higher > still)


def test_commands_are_within_the_rotors_limits(scenario, vehicle, hover):
    controller = make_controller(scenario, vehicle)
    context = controller.CreateDefaultContext()
    rotor = scenario.vehicle.rotor
    for away in 1e3 * np.vstack([np.eye(3), -np.eye(3)]):
        setpoint = hover + np.concatenate([away, np.zeros(6)])
        command = tick(controller, context, vehicle.trim_state, setpoint)
        assert np.all((rotor.min_thrust_n <= command) & (command <= rotor.max_thrust_n))


@pytest.mark.parametrize(("ratio", "expected"), [(0.99, 0), (1.01, 1)])
def test_the_limit_of_tilt_is_flagged(scenario, vehicle, hover, ratio, expected):
    """With an attitude law without torque, so that no torque is limited."""
    law = {"position_gain": (9, 9, 9), "attitude_gain": (0, 0, 0), "rate_gain": (0, 0, 0)}
    controller = make_controller(scenario, vehicle, **law)
    context = controller.CreateDefaultContext()
    hover[0] += ratio * GRAVITY * math.tan(scenario.flight.max_tilt_rad) / 9
    tick(controller, context, vehicle.trim_state, hover)
    assert controller.GetOutputPort("saturated").Eval(context) == expected


@pytest.mark.parametrize("axis", ["thrust", "roll", "pitch", "yaw"])
def test_the_limits_of_the_rotors_are_flagged_while_they_are_active(scenario, vehicle, hover, axis):
    """Thrust for a climb, torque against a rotation of the base."""
    controller = make_controller(scenario, vehicle)
    context = controller.CreateDefaultContext()
    saturated = controller.GetOutputPort("saturated")
    assert saturated.Eval(context) == 0  # Before the first command.
    for size, expected in ((0.02, 0), (10.0, 1), (0.0, 0)):
        state, setpoint = split_state(vehicle.trim_state.copy()), hover.copy()
        if axis == "thrust":
            setpoint[2] += size
        else:
            state.omega_W[["roll", "pitch", "yaw"].index(axis)] = size
        tick(controller, context, state.to_vector(), setpoint)
        assert saturated.Eval(context) == expected
        for _ in range(100 if size else 0):  # Until the observer has settled.
            tick(controller, context, vehicle.trim_state, hover)


class Flight:
    """The station under a base setpoint and a constant force on the base."""

    def __init__(self, scenario, vehicle, **flight):
        self.station = make_station(replace(scenario, flight=replace(scenario.flight, **flight)))
        self.context = make_context(self.station, 0)
        folded = np.concatenate([vehicle.working, np.zeros(2 * vehicle.joints)])
        self.station.GetInputPort("joint_setpoint").FixValue(self.context, folded)
        self.simulator = Simulator(self.station, self.context)

    def push(self, torque_and_force) -> None:
        """Applies a wrench at the base origin from now on, [N m, N] in the world frame."""
        force = np.zeros(6 + (self.output("true_state").size - 13) // 2)
        force[:6] = torque_and_force
        physics = self.station.GetSubsystemByName("physics")
        port = physics.GetInputPort("external_force")
        port.FixValue(physics.GetMyContextFromRoot(self.context), force)

    def advance(self, base_setpoint, duration: float) -> np.ndarray:
        """Returns base positions (samples, 3) m over the next `duration` s."""
        self.station.GetInputPort("base_setpoint").FixValue(self.context, base_setpoint)
        positions = []
        for end in self.context.get_time() + np.arange(0.05, duration + 1e-9, 0.05):
            self.simulator.AdvanceTo(end)
            positions.append(self.output("true_state")[4:7])
        return np.array(positions)

    def output(self, port: str) -> np.ndarray:
        return self.station.GetOutputPort(port).Eval(self.context)


def test_a_constant_force_is_estimated_and_rejected(scenario, vehicle, hover):
    flight = Flight(scenario, vehicle)
    force = np.array([2.0, -1.0, 3.0])
    flight.push([0, 0, 0, *force])
    p_B = flight.advance(hover, 6.0)
    assert np.abs(p_B - vehicle.p_B).max() > 0.02  # The push moves it at first.
    np.testing.assert_allclose(p_B[-1], vehicle.p_B, atol=1e-5)
    np.testing.assert_allclose(flight.output("disturbance")[:3], force / vehicle.mass, atol=1e-4)


@FEEDFORWARDS
def test_a_constant_torque_is_estimated_and_rejected(scenario, vehicle, hover, feedforward):
    flight = Flight(scenario, vehicle, feedforward=feedforward)
    torque = np.array([0.3, -0.2, 0.1])
    flight.push([*torque, 0, 0, 0])
    p_B = flight.advance(hover, 6.0)
    np.testing.assert_allclose(p_B[-1], vehicle.p_B, atol=1e-5)
    # In hover the rotors balance the push and the arm's weight; feedforward models the weight.
    unmodelled = torque - (feedforward == "none") * vehicle.trim_wrench[1:]
    expected = np.linalg.solve(vehicle.inertia, unmodelled)
    np.testing.assert_allclose(flight.output("disturbance")[3:], expected, atol=1e-4)
    np.testing.assert_allclose(flight.output("disturbance")[:3], 0, atol=1e-4)


@FEEDFORWARDS
@pytest.mark.parametrize("away", [(1000, 0, 0), (0, 0, 1000)])
def test_an_unreachable_setpoint_does_not_wind_up(scenario, vehicle, hover, away, feedforward):
    """The base returns with an integral as without one, and the ESO's disturbance stays small."""
    scenario = replace(scenario, vehicle=replace(scenario.vehicle, base_position_m=(0, 0, 50)))
    hover[2] = 50
    far = hover + np.concatenate([away, np.zeros(6)])
    lowest, highest = [], []
    for gain in (0.0, 2.0):
        gains = {"integral_gain": (gain,) * 3, "feedforward": feedforward}
        flight = Flight(scenario, replace(vehicle, p_B=hover[:3]), **gains)
        out = flight.advance(far, 1.5)
        assert np.abs(flight.output("disturbance")[:3]).max() < 3.0
        back = flight.advance(hover, 10.0)
        assert np.linalg.norm(out[-1] - hover[:3]) > 4
        np.testing.assert_allclose(back[-1], hover[:3], atol=0.3)
        lowest.append(back.min(axis=0))
        highest.append(back.max(axis=0))
    np.testing.assert_allclose(lowest[0], lowest[1], atol=0.5)
    np.testing.assert_allclose(highest[0], highest[1], atol=0.5)

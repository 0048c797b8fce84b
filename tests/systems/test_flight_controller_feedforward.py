"""Feedforward of arm and rotors in the flight controller, against the station's plant."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import Trajectory

from aerodrake.flight.excitation import make_open_loop
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody
from aerodrake.scenario import Scenario
from aerodrake.station import make_context

PERIOD = 0.01
DIRECTIONS = np.array([1.0, 0.8, -1.0, 1.0, 0.8, 1.0])
"""Direction of each joint's motion, towards the middle of its range."""


def motion(vehicle: VehicleModel, base_speed, joint_speed) -> tuple[Trajectory, Trajectory]:
    """Returns the motions of base and joints with the given velocities, sampled at `PERIOD`."""
    return (
        held_acceleration_motion(vehicle.p_B, base_speed, PERIOD),
        held_acceleration_motion(vehicle.working, joint_speed, PERIOD),
    )


def swing(vehicle: VehicleModel) -> tuple[Trajectory, Trajectory]:
    """Returns a motion of all joints by about 1 rad in 1 s and a second of rest; the base rests."""
    s = np.clip(PERIOD * np.arange(201), 0, 1)
    speed = 30 * s**2 - 60 * s**3 + 30 * s**4
    return motion(vehicle, np.zeros((201, 3)), speed[:, None] * DIRECTIONS)


def wave(vehicle: VehicleModel) -> tuple[Trajectory, Trajectory]:
    """Returns a smooth oscillation of base and joints from rest, for 4 s."""
    t = PERIOD * np.arange(401)
    ramp = (np.minimum(t, 1) ** 2 * (3 - 2 * np.minimum(t, 1)))[:, None]
    base = 0.6 * ramp * np.sin(0.8 * np.pi * t[:, None] + [0, 1, 2])
    return motion(vehicle, base, 0.4 * ramp * np.sin(np.pi * t[:, None]) * DIRECTIONS)


class Flown:
    """The station, with a motion as its setpoints."""

    def __init__(self, scenario: Scenario, feedforward: str, base, joints):
        flight = replace(scenario.flight, feedforward=feedforward)
        self.diagram = make_open_loop(replace(scenario, flight=flight), base, joints)
        self.context = make_context(self.diagram, 0)
        self.simulator = Simulator(self.diagram, self.context)
        self.ticks = round(base.end_time() / PERIOD)
        station = self.diagram.GetSubsystemByName("station")
        self.controller = station.GetSubsystemByName("flight_controller")

    def advance(self) -> Iterator[float]:
        """Stops just before each sample but the first, and yields its time."""
        for k in range(1, self.ticks):
            self.simulator.AdvanceTo(k * PERIOD - 0.0004)
            yield k * PERIOD

    def output(self, port: str) -> np.ndarray:
        return self.diagram.GetOutputPort(port).Eval(self.context).copy()

    def acceleration(self) -> np.ndarray:
        context = self.controller.GetMyContextFromRoot(self.context)
        return self.controller.GetOutputPort("acceleration").Eval(context).copy()

    @property
    def state(self) -> VehicleState:
        return split_state(self.output("true_state"))


@pytest.mark.parametrize("feedforward", ["whole_body", "none"])
def test_a_flight_starts_at_rest(scenario, vehicle, feedforward):
    """Nothing moves, with or without a model of the arm's weight."""
    still = motion(vehicle, np.zeros((51, 3)), np.zeros((51, vehicle.joints)))
    flown = Flown(scenario, feedforward, *still)
    thrust = flown.output("thrust")
    for _ in flown.advance():
        np.testing.assert_allclose(flown.output("true_state"), vehicle.trim_state, atol=1e-7)
        np.testing.assert_allclose(flown.output("thrust"), thrust, atol=1e-6)
        # The attitude observer's h cancels the modelled angular acceleration.
        total = flown.acceleration() + flown.output("disturbance")
        np.testing.assert_allclose(total, 0, atol=1e-6)


def test_the_base_stays_in_place_while_the_arm_swings(scenario, vehicle):
    """Within 3 mm sideways; with the observers alone it moves by more than 15 mm."""
    sideways, furthest = {}, {}
    for feedforward in ("whole_body", "none"):
        flown = Flown(scenario, feedforward, *swing(vehicle))
        moved = np.array([flown.state.p_B - vehicle.p_B for _ in flown.advance()])
        sideways[feedforward] = np.linalg.norm(moved[:, :2], axis=1).max()
        furthest[feedforward] = np.linalg.norm(moved, axis=1).max()
    assert sideways["whole_body"] < 0.003 and furthest["whole_body"] < 0.007
    assert sideways["none"] > 0.015


@pytest.fixture(scope="module")
def waved(scenario, vehicle):
    """Modelled and true motion between samples, from 0.05 s after the start.

    Columns: modelled and true mean acceleration (6); modelled specific thrust at a sample, and
    commanded one until then.
    """
    flown, rows, last = Flown(scenario, "whole_body", *wave(vehicle)), [], None
    for _ in flown.advance():
        now, modelled = flown.state, flown.acceleration()
        if last is not None:
            true = np.concatenate(
                [now.v_B - last.v_B, now.R_B.T @ now.omega_W - last.R_B.T @ last.omega_W]
            )
            commanded = flown.output("thrust_command").sum() / vehicle.mass
            rows.append((modelled, true / PERIOD, flown.output("specific_thrust")[0], commanded))
        last = now
    return [np.array(column) for column in zip(*rows[5:], strict=True)]


def test_the_modelled_acceleration_is_close_to_the_true_one(waved):
    """Up to the rotors' lag, and the effect of angular acceleration at the base's origin.

    The origin is 0.05 m above the centre of mass; the angular acceleration is 6 rad/s^2.
    """
    modelled, true, _, _ = waved
    size = np.abs(true).max(axis=0)
    assert np.all(size > [1.5, 1.5, 1.5, 5, 5, 0.5])
    error = np.abs(modelled - true)
    assert np.all(error.max(axis=0) < [0.4, 0.4, 0.25, 0.9, 0.9, 0.25])
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < 0.15 * size)


def test_the_modelled_thrust_follows_the_command_with_the_mean_lag(scenario, waved):
    _, _, modelled, commanded = waved
    rotor = scenario.vehicle.rotor
    decay = np.exp(-PERIOD / np.mean([rotor.lag_up_s, rotor.lag_down_s]))
    assert np.ptp(modelled) > 2.0
    expected = decay * modelled[:-1] + (1 - decay) * commanded[1:]
    np.testing.assert_allclose(modelled[1:], expected, atol=1e-9)


def test_the_disturbance_is_the_reaction_of_the_arm(scenario, vehicle):
    """While the arm swings, h is almost zero, and d is the reaction by inverse dynamics.

    The reaction is opposite to the force beyond gravity that keeps the base in place.
    """
    base, joints = swing(vehicle)
    flown, whole_body = Flown(scenario, "whole_body", base, joints), WholeBody(vehicle.plant)
    orders = joints, joints.MakeDerivative(1), joints.MakeDerivative(2)
    errors, sizes = [], []
    for time in flown.advance():
        q, qdot, qddot = (order.value(time - PERIOD / 2).ravel() for order in orders)
        state = split_state(vehicle.trim_state.copy())
        x = state._replace(q=q, qdot=qdot).to_vector()
        force = whole_body.effort(x, np.concatenate([np.zeros(6), qddot]))[3:6]
        expected = -(force / vehicle.mass - [0, 0, 9.81])
        errors.append(np.abs(flown.output("disturbance")[:3] - expected).max())
        sizes.append(np.abs(expected).max())
    assert max(sizes) > 0.15
    assert max(errors) < 0.06

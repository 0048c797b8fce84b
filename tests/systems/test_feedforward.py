"""What the flight controller knows of arm and rotors, against the station's own plant."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import Trajectory

from aerodrake.flight.open_loop import make_open_loop
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody
from aerodrake.scenario import Scenario
from aerodrake.station import make_context

PERIOD = 0.01
WAYS = np.array([1.0, 0.8, -1.0, 1.0, 0.8, 1.0])
"""Of each joint, towards the middle of its range."""


def motion(vehicle: VehicleModel, base_speed, joint_speed) -> tuple[Trajectory, Trajectory]:
    """Of base and joints, from their velocities each `PERIOD`."""
    return (
        held_acceleration_motion(vehicle.p_B, base_speed, PERIOD),
        held_acceleration_motion(vehicle.working, joint_speed, PERIOD),
    )


def swing(vehicle: VehicleModel) -> tuple[Trajectory, Trajectory]:
    """All joints by about 1 rad in 1 s, and a second of rest; the base is to stay."""
    s = np.clip(PERIOD * np.arange(201), 0, 1)
    speed = 30 * s**2 - 60 * s**3 + 30 * s**4
    return motion(vehicle, np.zeros((201, 3)), speed[:, None] * WAYS)


def wave(vehicle: VehicleModel) -> tuple[Trajectory, Trajectory]:
    """Base and joints together, smoothly from rest and around for 4 s."""
    t = PERIOD * np.arange(401)
    ramp = (np.minimum(t, 1) ** 2 * (3 - 2 * np.minimum(t, 1)))[:, None]
    base = 0.6 * ramp * np.sin(0.8 * np.pi * t[:, None] + [0, 1, 2])
    return motion(vehicle, base, 0.4 * ramp * np.sin(np.pi * t[:, None]) * WAYS)


class Flown:
    """The station along such a motion."""

    def __init__(self, scenario: Scenario, feedforward: str, base, joints):
        flight = replace(scenario.flight, feedforward=feedforward)
        self.diagram = make_open_loop(replace(scenario, flight=flight), base, joints)
        self.context = make_context(self.diagram, 0)
        self.simulator = Simulator(self.diagram, self.context)
        self.ticks = round(base.end_time() / PERIOD)
        station = self.diagram.GetSubsystemByName("station")
        self.controller = station.GetSubsystemByName("flight_controller")

    def advance(self) -> Iterator[float]:
        """Just before each sample but the first: its time."""
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
def test_it_starts_at_rest(scenario, vehicle, feedforward):
    """Nothing moves, whether the controller knows what the arm weighs or had to find out."""
    still = motion(vehicle, np.zeros((51, 3)), np.zeros((51, vehicle.joints)))
    flown = Flown(scenario, feedforward, *still)
    thrust = flown.output("thrust")
    for _ in flown.advance():
        np.testing.assert_allclose(flown.output("true_state"), vehicle.trim_state, atol=1e-7)
        np.testing.assert_allclose(flown.output("thrust"), thrust, atol=1e-6)
        # What is believed to turn the base is made up for by h.
        believed = flown.acceleration() + flown.output("disturbance")
        np.testing.assert_allclose(believed, 0, atol=1e-6)


def test_the_base_holds_still_while_the_arm_swings(scenario, vehicle):
    """Sideways within 3 mm, where the observers alone let it go by 15 mm and more."""
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
    """What was believed and what was true between samples 0.05 s after the start and later.

    By rows: believed and true mean acceleration (6), specific thrust (1) just before a sample.
    """
    flown, rows, last = Flown(scenario, "whole_body", *wave(vehicle)), [], None
    for _ in flown.advance():
        now, seen = flown.state, flown.acceleration()
        if last is not None:
            true = np.concatenate(
                [now.v_B - last.v_B, now.R_B.T @ now.omega_W - last.R_B.T @ last.omega_W]
            )
            thrust = flown.output("thrust").sum() / vehicle.mass
            rows.append((seen, true / PERIOD, flown.output("specific_thrust")[0], thrust))
        last = now
    return [np.array(column) for column in zip(*rows[5:], strict=True)]


def test_the_believed_acceleration_is_nearly_the_true_one(waved):
    """But for the rotors' lag, and for what turning adds at the origin.

    That is 0.05 m, by which it is above the centre of mass, times 6 rad/s^2.
    """
    believed, true, _, _ = waved
    size = np.abs(true).max(axis=0)
    assert np.all(size > [1.5, 1.5, 1.5, 5, 5, 0.5])
    miss = np.abs(believed - true)
    assert np.all(miss.max(axis=0) < [0.4, 0.4, 0.25, 0.9, 0.9, 0.25])
    assert np.all(np.sqrt(np.mean(miss**2, axis=0)) < 0.15 * size)


def test_the_believed_thrust_is_what_the_rotors_give(waved):
    _, _, believed, true = waved
    assert np.ptp(true) > 2.0
    np.testing.assert_allclose(believed, true, atol=0.006)


def test_the_disturbance_is_not_what_the_arm_is_known_to_take(scenario, vehicle):
    """h is nearly nothing as the arm swings, and d the arm's reaction, by inverse dynamics.

    The force beyond gravity that keeps the base in its place acts on it the other way round.
    """
    base, joints = swing(vehicle)
    flown, whole_body = Flown(scenario, "whole_body", base, joints), WholeBody(vehicle.plant)
    orders = joints, joints.MakeDerivative(1), joints.MakeDerivative(2)
    misses, sizes = [], []
    for time in flown.advance():
        q, qdot, qddot = (order.value(time - PERIOD / 2).ravel() for order in orders)
        state = split_state(vehicle.trim_state.copy())
        x = state._replace(q=q, qdot=qdot).to_vector()
        force = whole_body.effort(x, np.concatenate([np.zeros(6), qddot]))[3:6]
        expected = -(force / vehicle.mass - [0, 0, 9.81])
        misses.append(np.abs(flown.output("disturbance")[:3] - expected).max())
        sizes.append(np.abs(expected).max())
    assert max(sizes) > 0.15
    assert max(misses) < 0.06

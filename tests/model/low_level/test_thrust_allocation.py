"""Thrust allocation: within limits, exact where feasible, and yaw with the lowest priority."""

import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate, thrust_notes
from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Rotor, Scenario
from aerodrake.scenario import Vehicle as VehicleKeys

MIN, MAX = 0.5, 20.0
ARM = 0.329
QUAD = Rotors(
    names=("rotor_1_ccw", "rotor_2_cw", "rotor_3_ccw", "rotor_4_cw"),
    p_B=ARM * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]),
    spin=np.array([1.0, -1, 1, -1]),
)
MIXER = QUAD.mixer(0.02)
ALLOCATION = ThrustAllocation.of(MIXER, MIN, MAX)

thrusts = st.lists(st.floats(MIN, MAX), min_size=4, max_size=4).map(np.array)
# Zeros and round numbers on purpose: with them, thrusts are exactly at their limits.
torques = st.one_of(st.just(0.0), st.integers(-30, 30).map(float), st.floats(-30, 30))
wrenches = st.tuples(st.floats(-20, 150), torques, torques, torques).map(np.array)


def at_a_limit(thrust: np.ndarray) -> bool:
    return bool(np.any(np.minimum(thrust - MIN, MAX - thrust) < 1e-9))


@given(wrenches)
def test_thrusts_are_within_limits_for_every_wrench(wrench):
    thrust = allocate(ALLOCATION, wrench)
    assert thrust.shape == (4,)
    assert np.all((thrust >= MIN) & (thrust <= MAX))


@given(thrusts)
def test_exact_where_feasible(thrust):
    """For wrenches that are feasible with and without their yaw torque."""
    wrench = MIXER @ thrust
    without_yaw = np.linalg.solve(MIXER, wrench * [1, 1, 1, 0])
    assume(np.all((without_yaw >= MIN) & (without_yaw <= MAX)))
    np.testing.assert_allclose(allocate(ALLOCATION, wrench), thrust, atol=1e-9)


@given(wrenches, st.integers(0, 2**32))
def test_thrusts_are_continuous_in_the_wrench(wrench, seed):
    """At and beyond every limit."""
    step = 1e-6 * np.random.default_rng(seed).normal(size=4)
    moved = allocate(ALLOCATION, wrench + step) - allocate(ALLOCATION, wrench)
    assert np.abs(moved).max() < 1e-3


@given(wrenches)
def test_priorities(wrench):
    """Tilt before thrust before yaw; each is reduced no further than necessary."""
    lift, roll, pitch, yaw = MIXER @ allocate(ALLOCATION, wrench)
    # A torque changes each rotor's thrust by +- torque / (4 ARM).
    spread = 2 * (abs(wrench[1]) + abs(wrench[2])) / (4 * ARM)
    served = min(1.0, (MAX - MIN) / spread) if spread > 1e-9 else 1.0
    np.testing.assert_allclose([roll, pitch], served * wrench[1:3], atol=1e-9)

    # Without yaw, the least and the most loaded rotor bound the collective thrust.
    least, most = 4 * MIN + 2 * served * spread, 4 * MAX - 2 * served * spread
    assert lift == pytest.approx(np.clip(wrench[0], least, max(least, most)), abs=1e-9)

    assert abs(yaw) <= abs(wrench[3]) + 1e-9 and yaw * wrench[3] >= -1e-9
    if abs(yaw - wrench[3]) > 1e-6:
        assert at_a_limit(allocate(ALLOCATION, wrench))


@given(st.floats(0, 100), torques, torques)
def test_yaw_costs_neither_thrust_nor_tilt(lift, roll, pitch):
    """An infeasible yaw torque does not change the rest of the wrench."""
    without = MIXER @ allocate(ALLOCATION, np.array([lift, roll, pitch, 0.0]))
    with_yaw = MIXER @ allocate(ALLOCATION, np.array([lift, roll, pitch, 1e3]))
    np.testing.assert_allclose(with_yaw[:3], without[:3], atol=1e-9)


def test_makes_the_allocation_of_a_vehicle(scenario, vehicle):
    rotor = scenario.vehicle.rotor
    allocation = ThrustAllocation.make(vehicle, rotor)
    np.testing.assert_allclose(
        allocation.mixer @ allocate(allocation, vehicle.trim_wrench), vehicle.trim_wrench, atol=1e-9
    )
    most = allocate(allocation, np.array([1e3, 0.1, 0.1, 0.1]))
    assert most.max() == rotor.max_thrust_n


def test_more_rotors_than_wrench_components():
    angles = np.arange(6) * np.pi / 3
    hexa = Rotors(
        names=tuple(f"rotor_{i}_{'ccw' if i % 2 else 'cw'}" for i in range(6)),
        p_B=0.5 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]),
        spin=np.where(np.arange(6) % 2, 1.0, -1.0),
    )
    allocation = ThrustAllocation.of(hexa.mixer(0.02), MIN, MAX)
    wrench = np.array([40.0, 2.0, -1.0, 0.3])
    np.testing.assert_allclose(allocation.mixer @ allocate(allocation, wrench), wrench, atol=1e-9)


@pytest.mark.parametrize(
    ("rotor", "note"),
    [
        (Rotor(), None),
        (Rotor(max_thrust_n=9.0), r"vehicle.rotor.max_thrust_n \(9 N\) .* in hover \(9.7\d+ N\)"),
        (Rotor(min_thrust_n=9.5), r"vehicle.rotor.min_thrust_n \(9.5 N\) .* in hover \(8.9\d+ N\)"),
    ],
)
def test_rotors_that_cannot_hover_are_noted(rotor, note):
    scenario = Scenario(vehicle=VehicleKeys(rotor=rotor))
    notes = thrust_notes(scenario, VehicleModel.load(scenario))
    assert len(notes) == (note is not None)
    assert all(re.match(note, text) for text in notes)

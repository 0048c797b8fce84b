"""Sizes of multirotors for arms of any mass and reach."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.mounting.airframe import feet_positions, rotor_positions
from aerodrake.mounting.sizing import Given, Multirotor, two_digits

MASSES, REACHES = st.floats(0.02, 60), st.floats(0.05, 3)


def test_the_packaged_arm_gets_a_vehicle_like_the_packaged_one():
    """Base of 2.6 kg and 0.098 kg m^2, rotors of 20 N and 0.216 m at 0.465 m, feet at 0.38 m."""
    sized = Multirotor.for_arm(1.2, 0.54, Given())
    assert sized.rotors == 4 and sized.mass == pytest.approx(2.6, rel=0.05)
    assert sized.max_thrust == pytest.approx(20, rel=0.1)
    assert sized.disc == pytest.approx(0.216, rel=0.05)
    assert 0.35 < sized.radius < 0.5 and sized.feet == pytest.approx(0.38, rel=0.05)
    own = Multirotor(2.6, 4, 0.465, 0.216, 20.0, 0.02, (0.0125, 0.025), 0.38)
    assert own.inertia == pytest.approx([0.098, 0.098, 0.185], rel=0.05)


@given(MASSES, REACHES)
def test_laws_of_the_sizes(mass, reach):
    sized = Multirotor.for_arm(mass, reach, Given())
    total = mass + sized.mass
    assert 2.19 < sized.mass / mass < 2.5
    assert 0.42 < total * 9.81 / (sized.rotors * sized.max_thrust) <= 0.47
    places = rotor_positions(sized)
    gap = np.linalg.norm(places[0] - places[1])
    assert gap > 2.39 * sized.disc and sized.radius >= 0.5 * reach - 1e-9
    # Moments of inertia of a body, and torques that turn it: yaw is the weakest.
    level, _, upright = sized.inertia
    assert level < upright < 2 * level
    yaw = sized.torque_ratio * sized.rotors * sized.max_thrust / 4
    assert yaw / upright > 0.5 / max(1.0, (sized.radius / 0.465) ** 2)
    rotors = Rotors(tuple(map(str, places)), places, np.resize([1.0, -1.0], sized.rotors))
    assert not rotors.missing_torque()
    assert rotors.mixer(sized.torque_ratio)[1:] @ np.ones(sized.rotors) == pytest.approx([0, 0, 0])
    feet = feet_positions(sized)
    assert np.all(np.linalg.norm(feet[:, :2], axis=1) < sized.radius)


@given(MASSES, REACHES, st.floats(0, 20), st.tuples(*[st.booleans()] * 3))
def test_the_base_grows_with_the_inertia_of_the_arm(mass, reach, ratio, kept):
    """It does unless mass, or thrust, and radius are given; and no more than is needed."""
    plain = Multirotor.for_arm(mass, reach, Given())
    values = plain.mass, plain.radius, plain.max_thrust
    base_mass, radius, thrust = (
        x if is_kept else None for x, is_kept in zip(values, kept, strict=True)
    )
    sizes = Given(base_mass, plain.rotors, radius, thrust)
    sized = Multirotor.for_arm(mass, reach, sizes, ratio * plain.inertia[0])
    growth = sized.inertia[0] / plain.inertia[0]
    has_mass, has_radius, has_thrust = kept
    if ratio <= 2 or (has_radius and (has_mass or has_thrust)):
        assert growth == pytest.approx(1)
    else:
        assert ratio / 2 * (1 - 1e-9) <= growth
        if has_mass or has_radius:
            assert growth < 1.3 * ratio / 2
    for name, value, is_kept in zip(("mass", "radius", "max_thrust"), values, kept, strict=True):
        assert getattr(sized, name) == value if is_kept else getattr(sized, name) >= value


def test_a_base_grows_in_proportion():
    plain, grown = (Multirotor.for_arm(1.0, 0.5, Given(), inertia) for inertia in (0.0, 0.5))
    assert grown.mass / plain.mass == pytest.approx((grown.radius / plain.radius) ** 3, rel=0.1)


def test_larger_rotors_are_slower():
    small, large = (
        Multirotor.for_arm(mass, 0.5, Given(max_thrust=n)) for mass, n in ((1, 2.5), (9, 160))
    )
    assert small.lag == (0.0125, 0.025) and large.lag == (0.025, 0.05)
    assert small.disc == pytest.approx(0.108) and large.torque_ratio == pytest.approx(0.04)


def test_heavier_vehicles_have_more_rotors():
    rotors = [Multirotor.for_arm(mass, 0.5, Given()).rotors for mass in (0.5, 2.0, 4.0, 20.0)]
    assert rotors == [4, 4, 6, 8]


def test_given_sizes_are_kept():
    sized = Multirotor.for_arm(1.0, 0.5, Given(5.0, 6, 0.9, 33.0))
    assert (sized.mass, sized.rotors, sized.radius, sized.max_thrust) == (5.0, 6, 0.9, 33.0)


@given(st.floats(1e-3, 1e3))
def test_two_digits_round_up(value):
    rounded = two_digits(value)
    assert value * (1 - 1e-9) <= rounded <= value * 1.1 + 1e-12
    assert float(f"{rounded:.2g}") == pytest.approx(rounded, rel=1e-9)
    assert math.isclose(two_digits(rounded), rounded)

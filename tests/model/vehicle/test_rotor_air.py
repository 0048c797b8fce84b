"""Effects of the air on the rotors against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.vehicle.rotor_air import (
    RotorAir,
    ceiling_ratio,
    ground_ratio,
    inflow_ratio,
    rotor_forces,
)
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Air

THRUST = np.array([9.0, 10.0, 8.0, 9.5])
CALM = np.zeros(3)


def state(vehicle, v_B=(0, 0, 0), omega_W=(0, 0, 0), rpy=(0, 0, 0), height=1.5) -> np.ndarray:
    x = VehicleState.at_rest(np.array([0.0, 0.0, height]), vehicle.working, rpy)
    return x._replace(v_B=np.array(v_B, float), omega_W=np.array(omega_W, float)).to_vector()


def forces(vehicle, air: Air, x: np.ndarray, wind=CALM):
    return rotor_forces(RotorAir.make(air, vehicle.rotors), THRUST, np.array(wind, float), x)


@pytest.mark.parametrize(
    ("height", "ratio"), [(2.0, 1 / (1 - 1 / 64)), (1.0, 16 / 15), (0.5, 4 / 3), (0.1, 4 / 3)]
)
def test_ground_effect_of_cheeseman_and_bennett(height, ratio):
    assert ground_ratio(1.0, height) == pytest.approx(ratio)
    assert ground_ratio(0.2, 0.2 * height) == pytest.approx(ground_ratio(1.0, height))


def test_ceiling_effect():
    """The ratio is constant at less than half a radius, and 1 far away."""
    assert ceiling_ratio(1.0, np.inf) == 1.0
    assert ceiling_ratio(1.0, 0.5) == pytest.approx(((1 + np.sqrt(1.5)) / 2) ** (2 / 3))
    assert ceiling_ratio(1.0, 0.1) == ceiling_ratio(1.0, 0.5)
    assert ceiling_ratio(0.3, 3.0) == pytest.approx(1 + 0.01 / 48, abs=1e-6)  # First order.


def test_inflow_is_the_linearised_momentum_theory():
    """The slope of T / T_h at constant power, T (V / 2 + sqrt(V^2 / 4 + v_h^2 T / T_h)) = P."""
    v_h, V = 5.0, 1e-4

    def excess(ratio):  # Power over that in hover, where v_i follows from the thrust.
        return ratio * (V / 2 + np.sqrt(V**2 / 4 + v_h**2)) / v_h - 1

    ratio = 1.0 - excess(1.0)
    assert inflow_ratio(1 / (2 * v_h), V) == pytest.approx(ratio, abs=1e-9)
    assert inflow_ratio(0.1, -3.0) == pytest.approx(1.3)
    assert inflow_ratio(0.1, 100.0) == 0.0


@given(st.floats(-3, 3), st.floats(-0.5, 0.5))
def test_drag_is_in_the_rotor_plane_against_the_relative_velocity(vehicle, speed, tilt):
    x = state(vehicle, v_B=(speed, 0.2, 0.1), rpy=(0.0, tilt, 0.0))
    wind = np.array([0.5, -1.0, 0.0])
    drag = forces(vehicle, Air(rotor_drag_n_s_m=0.3), x, wind).drag
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    relative = wind - [speed, 0.2, 0.1]
    np.testing.assert_allclose(drag[3:], 0.3 * (relative - relative @ axis * axis), atol=1e-12)
    lever = vehicle.rotors.p_B[0, 2] * axis
    np.testing.assert_allclose(drag[:3], np.cross(lever, drag[3:]), atol=1e-12)


def test_drag_damps_yaw(vehicle):
    rate, air = 2.0, Air(rotor_drag_n_s_m=0.4)
    drag = forces(vehicle, air, state(vehicle, omega_W=(0, 0, rate))).drag
    squares = np.sum(vehicle.rotors.p_B[:, :2] ** 2, axis=1)
    np.testing.assert_allclose(drag, [0, 0, -0.1 * rate * squares.sum(), 0, 0, 0], atol=1e-12)


def test_inflow_damps_climb_and_roll(vehicle):
    air = Air(inflow_s_m=0.1)
    climbing = forces(vehicle, air, state(vehicle, v_B=(0, 0, 0.5)), wind=(0, 0, 0.2)).thrust
    np.testing.assert_allclose(climbing, THRUST * (1 - 0.03))
    rolling = forces(vehicle, air, state(vehicle, omega_W=(1.0, 0, 0))).thrust
    np.testing.assert_allclose(rolling, THRUST * (1 - 0.1 * vehicle.rotors.p_B[:, 1]))


def test_each_rotor_has_its_own_height(vehicle):
    air, roll = Air(rotor_radius_m=0.2, ceiling_m=1.0), 0.3
    x = state(vehicle, rpy=(roll, 0, 0), height=0.5)
    p = vehicle.rotors.p_B
    heights = 0.5 + np.sin(roll) * p[:, 1] + np.cos(roll) * p[:, 2]
    ratios = [ground_ratio(0.2, z) * ceiling_ratio(0.2, 1.0 - z) for z in heights]
    np.testing.assert_allclose(forces(vehicle, air, x).thrust, THRUST * ratios)
    assert len(np.unique(np.round(ratios, 6))) == 2

"""The estimator learns constant residuals that the model does not know."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Flight, Rotor
from tests.estimator_flights import (
    DT,
    JOINTS,
    equivalent_model,
    fly,
)
from tests.flight_equations import STATES, AxisLoop


@pytest.mark.parametrize("kind", ["paper", "exact", "velocity_aware"])
def test_learns_a_constant_residual_velocity(kind):
    residual = np.array([0.10, -0.05, 0.02])
    model = equivalent_model(kind)
    tick = {"state": np.zeros(VehicleState.size(JOINTS))}
    tick |= {"base_setpoint": np.zeros(9), "joint_setpoint": np.zeros(3 * JOINTS)}
    tick |= {"saturated": np.zeros(1), "x_0": np.zeros(len(model.A))}
    # At rest on its setpoint, the model alone predicts no motion.
    state = split_state(tick["state"])
    state.quaternion[0] = 1
    state.v_B[:] = model.C[model.base_velocity] @ residual
    tick["x_0"][model.base_velocity] = state.v_B
    log = fly(ResidualNetwork.untrained(JOINTS, 0), model, "online", 0.02, 20, [tick] * 300)

    np.testing.assert_allclose(log["delta"][-1], residual, atol=1e-4)
    assert np.linalg.norm(log["prediction_error"][-1]) < 1e-4
    np.testing.assert_allclose(log["nominal_prediction_error"][-1], -state.v_B, atol=1e-15)


def flown(x: np.ndarray, u: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Returns x (nx,) of the default flight model after DT, by its differential equations."""
    flight, rotor = Flight(), Rotor()
    tau = (rotor.lag_up_s + rotor.lag_down_s) / 2 + 0.005
    T_f, h_rate = flight.rate_filter_s + 0.010, flight.position_eso_rad_s / 3
    y = x[: 3 * len(STATES)].reshape(3, -1) * ([1] * (len(STATES) - 1) + [-T_f])  # w to low.
    for axis, about in enumerate((1, 0, None)):
        gains = flight.position_gain[axis], flight.velocity_gain[axis]
        attitude = None, None
        if about is not None:
            attitude = flight.attitude_gain[about], flight.rate_gain[about]
        loop = AxisLoop(flight.interface, *gains, *attitude, tau, T_f, h_rate)
        slope = partial(loop.slope, u=u[axis], delta=residual[axis])
        exact = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
        y[axis] = solve_ivp(lambda t, y, f=slope: f(y), (0, DT), y[axis], **exact).y[:, -1]
    y[:, -1] /= -T_f
    return np.concatenate([y.ravel(), x[y.size :]])


def test_learns_a_constant_acceleration_that_the_flight_model_does_not_know():
    """The base moves by the integrated equations; the flight controller rejects the residual."""
    model, residual = equivalent_model("flight"), np.array([0.5, -0.2, 0.1])
    rng, flight, x = np.random.default_rng(0), [], np.zeros(len(model.A))
    u = np.zeros(3 + JOINTS)
    for k in range(300):
        tick = {"state": np.zeros(VehicleState.size(JOINTS)), "x_0": x, "saturated": np.zeros(1)}
        tick |= {"base_setpoint": np.zeros(9), "joint_setpoint": np.zeros(3 * JOINTS)}
        state = split_state(tick["state"])
        state.quaternion[0] = 1
        state.v_B[:] = x[model.base_velocity]
        tick["base_setpoint"][6:] = u[:3]
        flight.append(tick)
        u[:3] = 0.3 * rng.normal(size=3) if k < 60 else 0.0
        x = flown(x, u, residual)
    log = fly(ResidualNetwork.untrained(JOINTS, 0), model, "online", 0.02, 20, flight)

    labels = -log["nominal_prediction_error"][1:] / model.residual_gain
    np.testing.assert_allclose(labels, np.tile(residual, (299, 1)), atol=1e-6)
    np.testing.assert_allclose(log["delta"][-1], residual, rtol=1e-3)

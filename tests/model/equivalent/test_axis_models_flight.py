"""Flight model: its equations by other means, and predictions of the station's flight."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp

from aerodrake.flight.excitation import excite
from aerodrake.model.equivalent.axis_models import (
    HIDDEN_STATES,
    RESIDUAL_ACCELERATION,
    flight_axis,
)
from aerodrake.model.equivalent.initial_state import Signals, Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Flight, Rotor, Scenario
from tests.flight_equations import STATES, AxisLoop

FLIGHT = Flight(
    position_gain=(9.0, 8.0, 7.0),
    velocity_gain=(5.0, 4.5, 4.0),
    attitude_gain=(150.0, 130.0, 36.0),
    rate_gain=(25.0, 22.0, 12.0),
    rate_filter_s=0.04,
    position_eso_rad_s=2.7,
)
ROTOR, PERIOD, DT = Rotor(lag_up_s=0.01, lag_down_s=0.03), 0.01, 0.02
TAU, T_F, H_RATE = 0.02 + 0.005, 0.04 + 0.01, 0.9
# By axis: what the position law, and the attitude law about the other axis, have.
K_P, K_V = (9.0, 8.0, 7.0), (5.0, 4.5, 4.0)
K_R, K_OMEGA = (130.0, 150.0), (22.0, 25.0)


def of(axis: int, interface: str = "trajectory", dt: float = DT):
    return flight_axis(axis, replace(FLIGHT, interface=interface), ROTOR, PERIOD, dt)


def state(axis_model, **values: float) -> np.ndarray:
    assert set(values) <= set(axis_model.states)
    return np.array([values.get(name, 0.0) for name in axis_model.states])


def loop(axis: int, interface: str) -> AxisLoop:
    attitude = (None, None) if axis == 2 else (K_R[axis], K_OMEGA[axis])
    return AxisLoop(interface, K_P[axis], K_V[axis], *attitude, TAU, T_F, H_RATE)


@pytest.mark.parametrize("interface", ["trajectory", "position"])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("dt", [0.005, 0.02, 0.1])
def test_solves_its_equations_under_constant_input_and_residual(axis, interface, dt):
    model, equations = of(axis, interface, dt), loop(axis, interface)
    *y, u, delta = np.random.default_rng(axis).normal(size=len(STATES) + 2)
    if axis == 2:
        y[STATES.index("r") :] = 0.0, 0.0, 0.0
    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    end = solve_ivp(lambda t, y: equations.slope(y, u, delta), (0, dt), y, **exact).y[:, -1]

    def x(y):
        *values, low = y
        return state(model, **dict(zip(STATES, values, strict=False)), w=-low / T_F)

    after = model.A @ x(y) + model.B * u + model.C * delta
    np.testing.assert_allclose(after, x(end), rtol=1e-10, atol=1e-10)
    assert model.residual == RESIDUAL_ACCELERATION


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_response_to_a_constant_acceleration_matches_the_transfer_function(axis):
    """From u to p, derived by hand from the blocks of the loop."""
    s = np.poly1d([1, 0])
    if axis == 2:
        top, bottom = np.poly1d([1]), TAU * s + 1
    else:
        filtered = T_F * s + 1
        top = K_R[axis] * filtered + K_OMEGA[axis] * s
        bottom = filtered * (TAU * s**3 + s**2 + K_OMEGA[axis] * s + K_R[axis])
    law = K_V[axis] * s + K_P[axis]
    loop = signal.TransferFunction(
        (top * (s**2 + law)).coeffs, (s**2 * (bottom * s**2 + top * law)).coeffs
    )
    times = DT * np.arange(51)
    _, expected = signal.step(loop, T=times)

    model = of(axis)
    x, p = state(model), [0.0]
    for _ in times[1:]:
        x = model.A @ x + model.B
        p.append(x[0])
    np.testing.assert_allclose(p, expected, atol=1e-6)
    assert abs(p[-1] - 0.5) < 0.1  # Near its setpoint, half a metre in a second.


@pytest.mark.parametrize("interface", ["trajectory", "position"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_thrust_rejects_a_constant_disturbance(axis, interface):
    """It converges to the setpoint with b = -d and h = d."""
    model = of(axis, interface)
    x = state(model, p=0.3, v=-0.2, p_d=1.0, b=0.5, d=0.7)
    for _ in range(2000):
        x = model.A @ x
    rest = {} if axis == 2 else {"w": 0.7 / T_F}
    np.testing.assert_allclose(x, state(model, p=1, p_d=1, b=-0.7, d=0.7, h=0.7, **rest), atol=1e-9)


@pytest.mark.parametrize(("interface", "lag_s"), [("trajectory", 0.0), ("position", 4.5 / 8.0)])
def test_lag_behind_a_moving_setpoint(interface, lag_s):
    """Only a controller with the input v_d has none: the other lags by k_v / k_p."""
    model = of(1, interface)
    x = state(model, v_d=0.4)
    for _ in range(1000):
        x = model.A @ x
    p, v, p_d, v_d = x[:4]
    np.testing.assert_allclose([p_d - p, v, v_d], [0.4 * lag_s, 0.4, 0.4], atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_residual_acts_like_the_external_acceleration(axis):
    """Except that d lasts beyond the period."""
    model = of(axis)
    np.testing.assert_allclose(model.C, model.A @ state(model, d=1.0) - state(model, d=1.0))
    np.testing.assert_allclose(model.C[:2], [DT**2 / 2, DT], rtol=0.02)


def test_thrust_alone_tilts_the_base():
    for axis in range(3):
        np.testing.assert_array_equal(of(axis).acceleration, state(of(axis), b=1.0))


# --- The station's own flight ---

FLOWN_S = 4.0


def chirp(vehicle, period: float):
    """Acceleration of the base from 0.2 to 0.6 Hz, with a steady swing of the joints."""
    t = period * np.arange(round(FLOWN_S / period) + 1)
    ramp = np.minimum(t, 1.0) ** 2 * (3 - 2 * np.minimum(t, 1.0))
    phase = 2 * np.pi * (0.2 * t + 0.05 * t**2)
    acceleration = 0.8 * ramp[:, None] * np.sin(phase[:, None] + [0, 1, 2])
    velocity = period * np.cumsum(np.vstack([np.zeros(3), acceleration[:-1]]), axis=0)
    swing = 0.5 * ramp[:, None] * np.sin(2 * np.pi * 0.8 * t)[:, None]
    joints = swing * np.where(np.arange(vehicle.joints) == 2, -1, 1)
    return (
        held_acceleration_motion(vehicle.p_B, velocity, period),
        held_acceleration_motion(vehicle.working, joints, period),
    )


class Flown:
    """Flight of the station along a chirp, and prediction errors of models at each tick."""

    def __init__(self, scenario: Scenario, vehicle):
        self.n = vehicle.joints
        self.record = excite(scenario, *chirp(vehicle, scenario.rates.mpc_period_s))
        self.states = [split_state(row) for row in self.record.state]
        self.u = np.hstack(
            [self.record.base_setpoint[:, 6:], self.record.joint_setpoint[:, 2 * self.n :]]
        )

    def thrust(self, k: int) -> Thrust:
        return Thrust.make(
            self.states[k],
            self.record.specific_thrust[k, 0],
            self.record.external_acceleration[k],
            self.record.disturbance[k],
        )

    def errors(self, model: EquivalentModel, ticks: int) -> np.ndarray:
        """Returns errors (samples, 3, 3) of p, v and b (0 without it) by axis, `ticks` later."""
        samples, x = [], None
        has_b = "b" in model.axis_states
        for k in range(1, len(self.u) - ticks):
            signals = Signals(
                self.states[k].p_B,
                self.states[k].v_B,
                np.concatenate([self.record.base_setpoint[k, :6], self.u[k - 1, :3]]),
                np.concatenate([self.record.joint_setpoint[k, : 2 * self.n], self.u[k - 1, 3:]]),
                self.thrust(k),
            )
            x = model.initial_state(signals, x)
            ahead = x
            for u in self.u[k : k + ticks]:
                ahead = model.predict(ahead, u, np.zeros(3))
            after = self.states[k + ticks]
            b = ahead[model.base_state("b")] - self.thrust(k + ticks).b if has_b else np.zeros(3)
            p, v = ahead[model.base_position], ahead[model.base_velocity]
            samples.append([p - after.p_B, v - after.v_B, b])
        return np.array(samples)


@pytest.fixture(scope="module", params=["trajectory", "position"])
def flown(request, vehicle):
    scenario = Scenario(flight=Flight(interface=request.param, feedforward="whole_body"))
    return scenario, Flown(scenario, vehicle)


@pytest.mark.parametrize(
    ("ticks", "p_m", "v_m_s", "b_m_s2"),
    [(1, 2.7e-5, 2.5e-3, 0.04), (5, 6e-4, 0.010, 0.075), (25, 6e-3, 0.018, 0.25)],
)
def test_predicts_the_flight_of_the_station(flown, ticks, p_m, v_m_s, b_m_s2):
    """From every tick; the base moves by 0.4 to 1.2 m."""
    scenario, flight = flown
    p = np.array([state.p_B for state in flight.states])
    assert np.ptp(p, axis=0).min() > 0.35
    model = EquivalentModel.of(scenario, flight.n)
    p, v, b = np.abs(flight.errors(model, ticks)).max(axis=(0, 2))
    assert p < p_m and v < v_m_s and b < b_m_s2


@pytest.mark.parametrize(("ticks", "times_better"), [(1, 15), (5, 3.5), (25, 1.15)])
@pytest.mark.parametrize("flown", ["trajectory"], indirect=True)
def test_predicts_many_times_better_than_the_first_order_model(flown, ticks, times_better):
    scenario, flight = flown
    aware = replace(scenario, model=replace(scenario.model, kind="velocity_aware"))
    flight_error, other_error = (
        np.sqrt(np.mean(flight.errors(EquivalentModel.of(s, flight.n), ticks)[:, 0] ** 2))
        for s in (scenario, aware)
    )
    assert flight_error < other_error / times_better


@pytest.mark.parametrize("flown", ["trajectory"], indirect=True)
def test_hidden_states_improve_the_prediction(flown):
    """With hidden states of zero at each tick, the prediction is much worse."""
    scenario, flight = flown
    model = EquivalentModel.of(scenario, flight.n)
    assert {model.axis_states[i % len(model.axis_states)] for i in model.hidden} == set(
        HIDDEN_STATES
    )
    kept = flight.errors(model, 5)
    A = model.A.copy()
    A[:, model.hidden] = 0.0
    forgotten = flight.errors(replace(model, A=A), 5)
    assert np.abs(forgotten[:, 2]).max() > 5 * np.abs(kept[:, 2]).max()

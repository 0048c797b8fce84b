"""Predictions and corrections of the estimate: gains, covariance, rotations, disturbances."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import PPoly
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.estimate import predict_base
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Filter, Sensors
from tests.estimates import CONFIG, DT, correct, estimate, rest, state_of

small = arrays(float, 3, elements=st.floats(-1, 1))
vector = arrays(float, 3, elements=st.floats(-10, 10))
rotation = arrays(float, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 0.1)


def quaternion(turn: Rotation) -> np.ndarray:
    """Returns the quaternion (4,), w first."""
    return turn.as_quat(scalar_first=True)


def turn_of(state: VehicleState) -> Rotation:
    return Rotation.from_quat(state.quaternion, scalar_first=True)


@cache
def riccati(value: float, rate: float, walk: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Steady-state gain and covariance of x''' = white noise, constant over a sample.

    The recursion itself, from a large covariance until it converges. Also G, the effect of a
    standard normal draw on the chain.
    """
    transition = expm(DT * np.eye(4, k=1))  # x, x', d and its constant rate.
    F, G = transition[:3, :3], transition[:3, 3:] * walk / np.sqrt(DT)
    H, R = np.eye(2, 3), np.diag([value**2, rate**2])
    P, L = 1e3 * np.eye(3), np.zeros((3, 2))
    for _ in range(2000):
        P = F @ P @ F.T + G @ G.T
        last, L = L, P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        P = (np.eye(3) - L @ H) @ P @ (np.eye(3) - L @ H).T + L @ R @ L.T
    np.testing.assert_allclose(L, last, rtol=1e-12)
    return L, P, G[:, 0]


@pytest.mark.parametrize("config", [Filter(), CONFIG])
@pytest.mark.parametrize("axis", range(3))
def test_gains_are_the_limit_of_the_riccati_recursion(config, axis):
    """Seen by the correction for a unit error, of value or rate, on one axis."""
    e = np.eye(3)[axis]
    gains = StateFilter.make(config, Sensors(), DT)
    predicted = estimate()
    L, _, _ = riccati(config.position_noise_m, config.velocity_noise_m_s, config.disturbance_m_s3)
    for k, sample in enumerate([rest(p_B=e), rest(v_B=e)]):
        corrected = correct(gains, predicted, sample.to_vector())
        expected = np.outer(L[:, k], e)
        np.testing.assert_allclose(
            [state_of(corrected).p_B, state_of(corrected).v_B, corrected.disturbance[:3]],
            expected,
            rtol=1e-6,
        )
        np.testing.assert_array_equal(corrected.disturbance[3:], 0)

    M, _, _ = riccati(config.attitude_noise_rad, config.rate_noise_rad_s, config.disturbance_rad_s3)
    turned = quaternion(Rotation.from_rotvec(e))
    for k, sample in enumerate([rest(quaternion=turned), rest(omega_W=e)]):
        corrected = correct(gains, predicted, sample.to_vector())
        theta = turn_of(state_of(corrected)).as_rotvec()
        expected = np.outer(M[:, k], e)
        np.testing.assert_allclose(
            [theta, state_of(corrected).omega_W, corrected.disturbance[3:]],
            expected,
            rtol=1e-6,
            atol=1e-15,
        )
        np.testing.assert_array_equal(corrected.disturbance[:3], 0)


def test_errors_have_the_covariance_that_the_recursion_predicts():
    """A chain on each axis, driven by known accelerations and noise of the assumed sizes."""
    samples = 4000
    noise = [CONFIG.position_noise_m, CONFIG.velocity_noise_m_s]
    _, P, G = riccati(*noise, CONFIG.disturbance_m_s3)
    F = expm(DT * np.eye(3, k=1))
    random = np.random.default_rng(0)
    gains = StateFilter.make(CONFIG, Sensors(), DT)
    x, now = np.zeros((3, 3)), estimate()  # Rows p, v, d.
    errors = []
    for k in range(samples):
        known = np.array([3 * np.sin(0.02 * k), 1.0, -2.0])
        x = F @ x + np.outer([DT**2 / 2, DT, 0], known) + np.outer(G, random.normal(size=3))
        z = x[:2] + np.array(noise)[:, None] * random.normal(size=(2, 3))
        predicted = predict_base(now, np.append(known, np.zeros(3)), DT)
        now = correct(gains, predicted, rest(p_B=z[0], v_B=z[1]).to_vector())
        errors.append(x - [state_of(now).p_B, state_of(now).v_B, now.disturbance[:3]])
    white = np.linalg.solve(np.linalg.cholesky(P), np.hstack(errors[100:]))
    # About 10 samples are correlated: four standard errors of some 1100 independent ones.
    np.testing.assert_allclose(white @ white.T / white.shape[1], np.eye(3), atol=0.17)
    np.testing.assert_allclose(white.mean(axis=1), 0, atol=0.12)


@given(
    start=arrays(float, (2, 3), elements=st.floats(-5, 5)),
    d=vector,
    accelerations=arrays(float, (7, 3), elements=st.floats(-10, 10)),
)
def test_known_accelerations_are_integrated_exactly(start, d, accelerations):
    """Against integrals of piecewise constant accelerations."""
    now = estimate(d=d, p_B=start[0], v_B=start[1])
    for a in accelerations:
        now = predict_base(now, np.append(a, np.zeros(3)), DT)
    times = DT * np.arange(len(accelerations) + 1)
    v = PPoly((accelerations + d)[None], times).antiderivative()
    np.testing.assert_allclose(state_of(now).v_B, start[1] + v(times[-1]), atol=1e-12)
    p = start[0] + start[1] * times[-1] + v.antiderivative()(times[-1])
    np.testing.assert_allclose(state_of(now).p_B, p, atol=1e-12)
    np.testing.assert_array_equal(now.disturbance[:3], d)


@given(attitude=rotation, axis=rotation, motion=arrays(float, 3, elements=st.floats(-30, 30)))
def test_rotation_about_a_constant_axis_is_composed_exactly(attitude, axis, motion):
    """From any attitude, unit quaternion or not, through any angle, at a known acceleration."""
    size = np.linalg.norm(axis[1:])
    e = axis[1:] / size if size > 1e-9 else np.array([0.0, 0, 1])
    rate, alpha, delta = motion
    R = Rotation.from_quat(attitude, scalar_first=True)
    now = estimate(delta=delta * e, quaternion=attitude, omega_W=R.apply(rate * e))
    for _ in range(30):
        now = predict_base(now, np.append(np.zeros(3), alpha * e), DT)
    t = 30 * DT
    angle = rate * t + (alpha + delta) * t**2 / 2
    expected = R * Rotation.from_rotvec(angle * e)
    np.testing.assert_allclose(turn_of(state_of(now)).as_matrix(), expected.as_matrix(), atol=1e-12)
    omega = expected.apply((rate + (alpha + delta) * t) * e)
    np.testing.assert_allclose(state_of(now).omega_W, omega, atol=1e-11)
    np.testing.assert_allclose(np.linalg.norm(state_of(now).quaternion), 1, atol=1e-12)
    np.testing.assert_allclose(now.disturbance[3:], delta * e)


@given(attitude=rotation, omega=vector, alpha=vector)
def test_rotation_about_a_changing_axis_is_of_third_order(attitude, omega, alpha):
    """Rates are exact; attitude up to dt^3 / 12 omega x alpha, against a hundred smaller turns."""
    R = Rotation.from_quat(attitude, scalar_first=True)
    now = estimate(quaternion=attitude, omega_W=R.apply(omega))
    later = state_of(predict_base(now, np.append(np.zeros(3), alpha), DT))
    np.testing.assert_allclose(later.R_B.T @ later.omega_W, omega + DT * alpha, atol=1e-12)
    turned, steps = R, 100
    for k in range(steps):
        mean = omega + (k + 0.5) * DT / steps * alpha
        turned = turned * Rotation.from_rotvec(DT / steps * mean)
    error = (turned.inv() * turn_of(later)).magnitude()
    assert error <= 1.1 * DT**3 / 12 * np.linalg.norm(np.cross(omega, alpha)) + 1e-12


@given(
    attitude=rotation,
    turn=small,
    omega=vector,
    rate_error=small,
    signs=st.tuples(*[st.sampled_from([-1.0, 1.0])] * 2),
)
def test_attitude_errors_are_rotations_in_the_base_frame(attitude, turn, omega, rate_error, signs):
    """The gain applies to the rotation vector between both, for either sign of the quaternions."""
    R = Rotation.from_quat(attitude, scalar_first=True)
    M = riccati(CONFIG.attitude_noise_rad, CONFIG.rate_noise_rad_s, CONFIG.disturbance_rad_s3)[0]
    predicted = estimate(quaternion=signs[0] * quaternion(R), omega_W=omega)
    sample = rest(
        quaternion=signs[1] * quaternion(R * Rotation.from_rotvec(turn)),
        omega_W=omega + R.apply(rate_error),
    )
    corrected = correct(StateFilter.make(CONFIG, Sensors(), DT), predicted, sample.to_vector())
    theta, rate, delta = M @ np.stack([turn, rate_error])
    expected = R * Rotation.from_rotvec(theta)
    np.testing.assert_allclose(
        turn_of(state_of(corrected)).as_matrix(), expected.as_matrix(), atol=1e-7
    )
    np.testing.assert_allclose(state_of(corrected).omega_W, omega + R.apply(rate), atol=1e-6)
    np.testing.assert_allclose(corrected.disturbance[3:], delta, rtol=1e-6, atol=1e-6)


@given(attitude=rotation, omega=vector, p=vector, v=vector, d=vector, delta=vector)
def test_a_sample_as_predicted_changes_nothing(attitude, omega, p, v, d, delta):
    R = Rotation.from_quat(attitude, scalar_first=True)
    predicted = estimate(d, delta, quaternion=quaternion(R), omega_W=omega, p_B=p, v_B=v)
    corrected = correct(StateFilter.make(CONFIG, Sensors(), DT), predicted, predicted.state)
    for field, expected in zip(corrected, predicted, strict=True):
        np.testing.assert_allclose(field, expected, atol=1e-12)


@pytest.mark.parametrize("config", [Filter(), CONFIG])
def test_a_step_of_the_disturbances_is_estimated_without_bias(config):
    d, delta = np.array([1.0, -2.0, 0.5]), np.array([0.0, 0.0, 4.0])
    gains = StateFilter.make(config, Sensors(), DT)
    now = estimate()
    for k in range(1, 401):
        t = k * DT
        sample = rest(
            p_B=d * t**2 / 2,
            v_B=d * t,
            quaternion=quaternion(Rotation.from_rotvec(delta * t**2 / 2)),
            omega_W=delta * t,
        )
        now = correct(gains, predict_base(now, np.zeros(6), DT), sample.to_vector())
    np.testing.assert_allclose(now.disturbance[:3], d, rtol=1e-6)
    np.testing.assert_allclose(now.disturbance[3:], delta, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(state_of(now).p_B, sample.p_B, rtol=1e-8)
    np.testing.assert_allclose(state_of(now).v_B, sample.v_B, rtol=1e-7)
    np.testing.assert_allclose(turn_of(state_of(now)).as_matrix(), sample.R_B, atol=1e-8)

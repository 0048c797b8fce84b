"""Extended state observer against its specified poles and exact integrator chains."""

import math

import numpy as np
import pytest

from aerodrake.model.low_level.eso import ExtendedStateObserver, observe

CASES = [(order, w, dt) for order in (1, 2) for w in (3.0, 15.0, 80.0) for dt in (0.005, 0.02)]


def chain(order: int, dt: float, start: np.ndarray, u: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Returns samples (K + 1, order, axes) of y^(order) = u_k + h, in closed form."""
    states = [start]
    for u_k in u:
        x, a = states[-1], u_k + h
        states.append(
            np.array([x[0] + x[1] * dt + a * dt**2 / 2, x[1] + a * dt])
            if order == 2
            else np.array([x[0] + a * dt])
        )
    return np.array(states)


@pytest.mark.parametrize(("order", "w", "dt"), CASES)
def test_poles(order, w, dt):
    eso = ExtendedStateObserver.make(order, w, dt)
    # error+ = (I - L C) A error, since the sample corrects the prediction.
    correct = np.eye(order + 1) - np.outer(eso.L, np.eye(order + 1)[0])
    poles = np.linalg.eigvals(correct @ eso.A)
    # A pole of multiplicity m is accurate to the m-th root of the rounding error.
    np.testing.assert_allclose(poles, math.exp(-w * dt), atol=1e-4)
    polynomial = np.poly(correct @ eso.A)
    np.testing.assert_allclose(polynomial, np.poly([math.exp(-w * dt)] * (order + 1)), atol=1e-12)


@pytest.mark.parametrize(("order", "w", "dt"), CASES)
def test_estimates_an_exact_chain_without_bias(order, w, dt):
    """Initialised with the true state it equals the true state, for any known input."""
    rng = np.random.default_rng(0)
    h, u = rng.normal(size=3), rng.normal(size=(50, 3))
    truth = chain(order, dt, rng.normal(size=(order, 3)), u, h)
    eso = ExtendedStateObserver.make(order, w, dt)
    x = np.vstack([truth[0], h])
    for u_k, sample in zip(u, truth[1:], strict=True):
        x = observe(eso, x, u_k, sample[0])
        np.testing.assert_allclose(x, np.vstack([sample, h]), atol=1e-9)


@pytest.mark.parametrize(("order", "w", "dt"), CASES)
def test_converges_to_a_constant_disturbance(order, w, dt):
    rng = np.random.default_rng(1)
    h = np.array([2.0, -1.0, 0.5])
    u = rng.normal(size=(round(25 / (w * dt)), 3))
    truth = chain(order, dt, np.zeros((order, 3)), u, h)
    eso = ExtendedStateObserver.make(order, w, dt)
    x = np.zeros((order + 1, 3))
    for k, u_k in enumerate(u):
        x = observe(eso, x, u_k, truth[k + 1, 0])
    np.testing.assert_allclose(x, np.vstack([truth[-1], h]), atol=1e-4)


def test_other_orders_raise():
    with pytest.raises(ValueError, match="order"):
        ExtendedStateObserver.make(3, 1.0, 0.01)

"""Linear residual models on synthetic flights."""

import numpy as np
import pytest

from aerodrake.model.residual.linear_residual import ALPHAS, LinearResidual

GENERATOR = np.random.default_rng(0)
SLOPE, INTERCEPT = GENERATOR.normal(size=(3, 5)), GENERATOR.normal(size=3)


def flight(samples=200, noise=0.0, seed=1):
    generator = np.random.default_rng(seed)
    features = generator.normal(size=(samples, 5)) * [1, 10, 0.1, 1, 1] + 3
    return features, features @ SLOPE.T + INTERCEPT + noise * generator.normal(size=(samples, 3))


def test_least_squares_recovers_an_affine_map():
    features, targets = flight(seed=2)
    assert LinearResidual.fit([flight(), flight(seed=3)], 0.0).predict(features) == pytest.approx(
        targets
    )


def test_a_constant_feature_has_no_coefficient():
    features, targets = flight()
    features[:, 2] = 1.0
    fit = LinearResidual.fit([(features, targets)], 0.0)
    assert fit.coefficients[:, 2] == pytest.approx(0)


def test_ridge_solves_its_normal_equations():
    features, targets = flight(noise=0.5)
    fit = LinearResidual.fit([(features, targets)], 0.1)
    X = (features - features.mean(axis=0)) / features.std(axis=0)
    Y = targets - targets.mean(axis=0)
    expected = np.linalg.solve(X.T @ X + 0.1 * len(X) * np.eye(5), X.T @ Y)
    np.testing.assert_allclose(fit.coefficients[:, :-1].T, expected)


def test_the_penalty_minimises_the_validation_error():
    few, many = flight(samples=7, noise=2.0), flight(samples=500, seed=5)
    ridge = LinearResidual.fit_ridge([few], [many])

    def error(alpha):
        return ((LinearResidual.fit([few], alpha).predict(many[0]) - many[1]) ** 2).sum()

    assert error(ridge.alpha) == min(error(alpha) for alpha in ALPHAS) < error(0.0)

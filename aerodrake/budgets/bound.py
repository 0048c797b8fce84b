"""Bound of the error by the optimal estimate of the base's position."""

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.special import roots_hermitenorm

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario

TIME_S = 8.0
"""Time for which the covariance is propagated to its periodic steady state."""

NODES = 24
"""Nodes of the Gauss-Hermite quadrature along each axis."""


class GustChain(NamedTuple):
    """Motion of the base along one axis, with the gusts' acceleration: states p, v, a.

    Attributes:
        F: (3, 3) transition over one sampling period.
        Q: (3, 3) covariance of its noise.
    """

    F: np.ndarray
    Q: np.ndarray


def error_bound(scenario: Scenario, vehicle: VehicleModel) -> float:
    """Returns the mean distance in m by which the best estimate misses the base's position.

    No controller that has only the scenario's sensors has a smaller mean error. The optimal
    estimator of a linear Gaussian system is the Kalman filter, in steady state. Its model is
    exact: only the gusts are random. Their Ornstein-Uhlenbeck process acts through the drag,
    whose mean slope replaces it (statistical linearisation). The filter has samples of the base's
    position and velocity, and the accelerometer's if there is one, each at its own period. They
    arrive with the known delay and the least latency, over which the filter predicts. Attitude and
    joints are known: nothing random acts on them. A tool sensor is left out: with one, the bound is
    that of controllers that do not use it. Without noise or without gusts the bound is zero.
    """
    sensors = scenario.sensors
    noise = sensors.position_noise_m, sensors.velocity_noise_m_s
    gusts = np.array(scenario.wind.gust_m_s)
    if not any(noise) or not gusts.any():
        return 0.0
    deviations = gust_accelerations(scenario, vehicle.mass)
    return mean_norm(np.sqrt([position_variance(scenario, sigma) for sigma in deviations]))


def gust_accelerations(scenario: Scenario, mass: float) -> np.ndarray:
    """Returns (3,) m/s^2, standard deviation of the base's acceleration by gusts on each axis.

    Args:
        scenario: Wind, payload and mismatch.
        mass: kg, of the vehicle as in its URDF.
    """
    wind = scenario.wind
    gusts, weights = _normal_vectors(np.array(wind.gust_m_s))
    air = np.array(wind.velocity_m_s) + gusts
    speed = np.maximum(np.linalg.norm(air, axis=1, keepdims=True), np.finfo(float).tiny)
    slopes = wind.quadratic_drag_n_s2_m2 * (speed + air**2 / speed) + wind.linear_drag_n_s_m
    flown = mass * scenario.mismatch.mass_scale + scenario.payload.mass_kg
    return weights @ slopes / flown * wind.gust_m_s


def position_variance(scenario: Scenario, sigma: float) -> float:
    """Returns the variance in m^2 of the best estimate of the position along one axis.

    It is the mean over time, in which it grows from one sample to the next.

    Args:
        scenario: Sensors and gusts.
        sigma: m/s^2, standard deviation of the gusts' acceleration.
    """
    sensors, step = scenario.sensors, scenario.rates.plant_step_s
    position, accelerometer = sensors.position, sensors.accelerometer
    noise = np.diag(np.square([sensors.position_noise_m, sensors.velocity_noise_m_s]))
    samples = [(position.period_s or scenario.rates.sensor_period_s, np.eye(2, 3), noise)]
    if accelerometer.period_s:
        variance = np.array([[accelerometer.noise_m_s2**2]])
        samples.append((accelerometer.period_s, np.eye(3)[2:], variance))
    steps = [round(period / step) for period, _, _ in samples]
    cycle = math.lcm(*steps)
    correlation_s = scenario.wind.gust_correlation_s
    chain = gust_chain(sigma, correlation_s, step)
    late = gust_chain(sigma, correlation_s, sensors.base_delay_s + position.latency_s[0])
    P = np.diag([noise[0, 0], noise[1, 1], sigma**2])
    variances = []
    for now in range(-(-round(TIME_S / step) // cycle) * cycle):
        P = chain.F @ P @ chain.F.T + chain.Q
        for every, (_, H, R) in zip(steps, samples, strict=True):
            if now % every == 0:
                P = P - P @ H.T @ np.linalg.solve(H @ P @ H.T + R, H @ P)
        variances.append((late.F @ P @ late.F.T + late.Q)[0, 0])
    return float(np.mean(variances[-cycle:]))


def mean_norm(deviations: np.ndarray) -> float:
    """Returns the mean Euclidean norm of a normal vector (3,) with these standard deviations."""
    vectors, weights = _normal_vectors(deviations)
    return float(weights @ np.linalg.norm(vectors, axis=1))


def _normal_vectors(deviations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns vectors (m, 3) with weights (m,), the nodes of the product quadrature."""
    nodes, weights = roots_hermitenorm(NODES)
    grid = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    product = np.prod(np.meshgrid(weights, weights, weights, indexing="ij"), axis=0).ravel()
    return grid * deviations, product / product.sum()


def gust_chain(sigma: float, correlation_s: float, dt: float) -> GustChain:
    """Returns the chain p' = v, v' = a, a' = -a / T + white noise, discretised exactly.

    Args:
        sigma: m/s^2, stationary standard deviation of a.
        correlation_s: s, T.
        dt: s.
    """
    A = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -1 / correlation_s]])
    Q = np.diag([0.0, 0.0, 2 * sigma**2 / correlation_s])
    # Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23 (1978).
    block = expm(np.block([[-A, Q], [np.zeros((3, 3)), A.T]]) * dt)
    F = block[3:, 3:].T
    return GustChain(F, F @ block[:3, 3:])

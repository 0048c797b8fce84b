"""Check that accepts or rejects each group of a sample: finite, new, and plausible.

The groups are position (p_B and v_B), attitude (quaternion and omega_W), and joints (q and q').
Each comes from a sensor of its own and has a verdict of its own.
"""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.sensing.encoder import Encoder
from aerodrake.model.sensing.estimate import Estimate
from aerodrake.model.sensing.position_jump import (
    Jump,
    JumpLimits,
    extend_jump,
    has_jumped,
    is_lasting,
)
from aerodrake.model.sensing.sample import ATTITUDE, GROUPS, JOINTS, POSITION, Sample, group_of
from aerodrake.model.sensing.sample_health import Verdict, is_accepted, split_health
from aerodrake.model.vehicle.rotation import conjugate, length, product, rotation_vector
from aerodrake.scenario import Filter, Sensors
from aerodrake.support.compiled import compiled

MAX_MAGNITUDE = 1e4
"""m, rad, m/s or rad/s: larger positions, angles and velocities are not plausible."""

UNIT_LENGTH = 0.1
"""Tolerated deviation of a quaternion's length from 1; the plant's drifts slightly."""

RESOLUTION = np.array([3e-4, 3e-4, 1e-3])
"""m, rad, rad: motion after which sensors of floating-point resolution measure other values."""

QUANTA = 4.0
"""Motion of all joints together, in steps of their encoders, after which one measures another."""

NOISE_DEVIATIONS = 8.0
"""Bound of the noise in standard deviations."""

OUTAGE_SAMPLES = 3
"""Samples after the last accepted one that are still compared with it, not with the prediction."""

ACCELERATION = np.array([60.0, 300.0, 600.0])
"""m/s^2, rad/s^2, rad/s^2: largest plausible acceleration from one sample to the next."""

SLACK = np.array([0.05, 0.02, 0.05])
"""m, rad, rad: tolerated error of a prediction from the start."""

RATE_SLACK = np.array([1.0, 1.0, 3.0])
"""m/s, rad/s, rad/s: tolerated error of a predicted velocity from the start."""

DRIFT = np.array([0.4, 1.5, 8.0])
"""m/s^2, rad/s^2, rad/s^2: tolerated error of modelled accelerations at first. Each second of an
outage adds as much again, so that every drift is eventually within the bound."""

DRIFT_RATIO = 0.25
"""Tolerated relative change of the estimated disturbance: strong disturbances vary more."""


class SampleCheck(NamedTuple):
    """Bounds on the steps and innovations of samples, by group.

    A sample is accepted if it *follows* from the last accepted one: if both differ by no more
    than the mean of their velocities and a plausible acceleration allow. This does not depend on
    any model. After an outage of a few samples, a sample is accepted if it is near the
    *prediction*, within a bound that grows with the time of the outage. A step is therefore never
    accepted at once. A lasting step is accepted when the bound has grown to its size: 0.5 rad
    after 0.7 s, in still air. A lasting step of the position, as after a reset of the estimator
    that measures it, is also accepted within the limits of `jump`.

    Attributes:
        noise: (3,) m, rad, rad: bound of the noise on a value.
        rate_noise: (3,) m/s, rad/s, rad/s: bound of the noise on its velocity.
        period: (3,) s, between the samples of a group: `dt`, or more if its sensor is slower.
        jitter: (3,) s, largest difference of two latencies.
        resolution: (3,) m, rad, rad: motion after which the same values cannot be measured again.
        jump: Limits of a lasting step of the position.
        dt: s, between samples.
    """

    noise: np.ndarray
    rate_noise: np.ndarray
    period: np.ndarray
    jitter: np.ndarray
    resolution: np.ndarray
    jump: JumpLimits
    dt: float

    @classmethod
    def make(cls, config: Filter, sensors: Sensors, dt: float) -> Self:
        """Returns the bounds for the noise that the filter assumes, or the sensors' if larger.

        Slow sensors, latencies and the encoders' resolution widen them.
        """
        noise = np.maximum(
            [config.position_noise_m, config.attitude_noise_rad, config.joint_noise_rad],
            [sensors.position_noise_m, sensors.attitude_noise_rad, sensors.joint_noise_rad],
        )
        rate_noise = np.maximum(
            [config.velocity_noise_m_s, config.rate_noise_rad_s, 0.0],
            [sensors.velocity_noise_m_s, sensors.rate_noise_rad_s, 0.0],
        )
        periods = np.array([sensors.each[group].period_s or dt for group in GROUPS])
        jitter = np.array([np.ptp(sensors.each[group].latency_s) for group in GROUPS])
        bounds, resolution = NOISE_DEVIATIONS * noise, RESOLUTION.copy()
        rate_bounds = NOISE_DEVIATIONS * rate_noise
        encoder = Encoder.make(sensors.joints)
        bounds[JOINTS] += encoder.quantum_rad
        resolution[JOINTS] = max(resolution[JOINTS], QUANTA * encoder.quantum_rad)
        rate_deviation = encoder.rate_deviation(sensors.joint_noise_rad, periods[JOINTS])
        rate_bounds[JOINTS] += NOISE_DEVIATIONS * rate_deviation
        times = np.maximum(periods, dt), jitter
        return cls(bounds, rate_bounds, *times, resolution, JumpLimits.make(config), dt)


class CheckState(NamedTuple):
    """State of the sample check after a sample.

    Attributes:
        sample: (13 + 2 n,) the sample, accepted or not; NaN before the first.
        stamps: (3,) s, the last finite time stamp of each group.
        accepted: (13 + 2 n,) the last accepted values of each group; NaN before the first.
        travel: (3,) m, rad, rad: expected motion of each group since its values last changed.
        health: (6,) `SampleHealth` of the sample.
        jump: Jump of the positions that were rejected since the last accepted one.
    """

    sample: np.ndarray
    stamps: np.ndarray
    accepted: np.ndarray
    travel: np.ndarray
    health: np.ndarray
    jump: Jump

    @classmethod
    def accepting(cls, sample: np.ndarray, stamp: float) -> Self:
        """Returns the state after a sample (13 + 2 n,) of the time `stamp` s was accepted."""
        return cls(sample, np.full(3, stamp), sample, np.zeros(3), np.zeros(6), Jump.none())

    @classmethod
    def initial(cls, size: int, stamp: float) -> Self:
        """Returns the state before a first sample of `size` values later than `stamp` s.

        The first sound values of each group are accepted, whatever they are.
        """
        return cls.accepting(np.full(size, np.nan), stamp)


@compiled
def has_begun(g: int, last: CheckState) -> bool:
    """Returns True if a sample of group `g` has been accepted."""
    return np.isfinite(group_of(g, last.accepted)[0][0])


@compiled
def check(bounds: SampleCheck, last: CheckState, predicted: Estimate, sample: Sample) -> CheckState:
    """Accepts or rejects each group of a sample.

    Args:
        bounds: Bounds on steps and innovations.
        last: State after the previous sample.
        predicted: Estimate of what the sample should be.
        sample: As it arrived.
    """
    stamps, accepted, travel = last.stamps.copy(), last.accepted.copy(), last.travel.copy()
    health, jump = last.health.copy(), last.jump
    ages, verdicts = split_health(health)
    for g in range(3):
        x, rate = group_of(g, sample.state)
        x_last, rate_last = group_of(g, last.sample)
        if np.all(x == x_last) and np.all(rate == rate_last):
            _, rate_predicted = group_of(g, predicted.state)
            travel[g] += bounds.dt * max(length(rate), length(rate_predicted))
        else:
            travel[g] = 0.0

        ages[g] += bounds.dt
        if not last.stamps[g] < sample.stamps[g] < np.inf:
            verdict = Verdict.STALE.value
        elif not _is_finite(g, x, rate):
            verdict = Verdict.NOT_FINITE.value
        elif travel[g] > bounds.resolution[g]:
            verdict = Verdict.FROZEN.value
        elif not has_begun(g, last):
            starts_late = g == POSITION and split_health(last.health).ages[g] > 0
            verdict = Verdict.RESET.value if starts_late else Verdict.OK.value
        else:
            is_plausible = _is_plausible(bounds, g, last, predicted, sample.state)
            verdict = Verdict.OK.value if is_plausible else Verdict.JUMP.value
            if g == POSITION:
                verdict, jump = _check_jump(bounds, last, predicted, sample.state, is_plausible)
        if is_accepted(verdict):
            ages[g] = 0.0
            x_accepted, rate_accepted = group_of(g, accepted)
            x_accepted[:], rate_accepted[:] = x, rate
        verdicts[g] = verdict
        # No later stamp would be larger than an infinite one, or than NaN.
        if np.isfinite(sample.stamps[g]):
            stamps[g] = sample.stamps[g]
    return CheckState(sample.state.copy(), stamps, accepted, travel, health, jump)


@compiled
def is_outage(bounds: SampleCheck, g: int, age: float) -> bool:
    """Returns True if the last accepted sample of group `g` is too old to compare with.

    `age` in s is the time from the last accepted sample to the previous sample.
    """
    return age > (OUTAGE_SAMPLES - 0.5) * bounds.period[g]


@compiled
def _is_plausible(
    bounds: SampleCheck, g: int, last: CheckState, predicted: Estimate, state: np.ndarray
) -> bool:
    """Returns True if a group follows from the last accepted one or, in an outage, is as predicted.

    Velocities are bounded likewise.
    """
    age, (x, rate) = split_health(last.health).ages[g], group_of(g, state)
    since = age + bounds.dt
    if not is_outage(bounds, g, age):
        noise, rate_noise = bounds.noise[g], bounds.rate_noise[g]
        a, (x_accepted, rate_accepted) = ACCELERATION[g], group_of(g, last.accepted)
        step = _difference(g, x_accepted, x) - since / 2 * (rate_accepted + rate)
        jitter, most = bounds.jitter[g], since + bounds.jitter[g]
        late = jitter * max(length(rate_accepted), length(rate))
        is_within = length(step) <= 2 * noise + since * rate_noise + a * most**2 / 4 + late
        return is_within and length(rate - rate_accepted) <= 2 * rate_noise + a * most
    bound, rate_bound = _prediction_bounds(bounds, g, predicted, since)
    x_predicted, rate_predicted = group_of(g, predicted.state)
    is_within = length(_difference(g, x_predicted, x)) <= bound
    return is_within and length(rate - rate_predicted) <= rate_bound


@compiled
def _prediction_bounds(
    bounds: SampleCheck, g: int, predicted: Estimate, since: float
) -> tuple[float, float]:
    """Returns the bounds of the deviation of a group's values and velocities from a prediction.

    `since` in s is the time over which it was predicted.
    """
    disturbance = 0.0  # Joints have none.
    if g == POSITION:
        disturbance = length(predicted.disturbance[:3])
    elif g == ATTITUDE:
        disturbance = length(predicted.disturbance[3:])
    a = DRIFT[g] + DRIFT_RATIO * disturbance
    drift, rate_drift = a * since**2 / 2 + a * since**3 / 6, a * since + a * since**2 / 2
    _, rate = group_of(g, predicted.state)
    drift += bounds.jitter[g] * length(rate)
    rate_drift += bounds.jitter[g] * ACCELERATION[g]
    return SLACK[g] + bounds.noise[g] + drift, RATE_SLACK[g] + bounds.rate_noise[g] + rate_drift


@compiled
def _check_jump(
    bounds: SampleCheck,
    last: CheckState,
    predicted: Estimate,
    state: np.ndarray,
    is_plausible: bool,
) -> tuple[int, Jump]:
    """Returns the `Verdict` on a position, and the jump of the rejected ones including it."""
    position, velocity = group_of(POSITION, state)
    predicted_position, predicted_velocity = group_of(POSITION, predicted.state)
    deviation = position - predicted_position
    if is_plausible:
        jumped = has_jumped(last.jump, deviation)
        return Verdict.RESET.value if jumped else Verdict.OK.value, Jump(np.zeros(3), 0.0)
    period = bounds.period[POSITION]
    since_jump = last.jump.duration_s + period
    tolerance, _ = _prediction_bounds(bounds, POSITION, predicted, since_jump)
    jump = extend_jump(last.jump, deviation, tolerance + bounds.noise[POSITION], period)
    since_accepted = split_health(last.health).ages[POSITION] + bounds.dt
    tolerance, rate_bound = _prediction_bounds(bounds, POSITION, predicted, since_accepted)
    is_reset = is_lasting(bounds.jump, jump, tolerance, period)
    if is_reset and length(velocity - predicted_velocity) <= rate_bound:
        return Verdict.RESET.value, Jump(np.zeros(3), 0.0)
    return Verdict.JUMP.value, jump


@compiled
def _is_finite(g: int, x: np.ndarray, rate: np.ndarray) -> bool:
    """Returns True if a group is finite and of plausible magnitude, a quaternion of unit length."""
    size = length(x)
    is_sound = abs(size - 1) < UNIT_LENGTH if g == ATTITUDE else size < MAX_MAGNITUDE
    return is_sound and length(rate) < MAX_MAGNITUDE


@compiled
def _difference(g: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns b - a; of quaternions, the rotation vector in the world from a to b."""
    return rotation_vector(product(b, conjugate(a))) if g == ATTITUDE else b - a

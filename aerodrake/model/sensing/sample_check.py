"""Which parts of a sample are believed: finite, new, and where the vehicle can have gone.

A sample has three groups, since three sensors make it: position (p_B and v_B), attitude
(quaternion and omega_W), joints (q and q'). Each has its verdict.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from aerodrake.model.sensing.sample import ATTITUDE, group_of
from aerodrake.model.vehicle.rotation import (
    conjugate,
    length,
    product,
    rotation_vector,
)
from aerodrake.scenario import Filter, Sensors
from aerodrake.support.compiled import compiled


class Verdict(IntEnum):
    """Of one group of a sample; where several are true, STALE comes first, then in this order."""

    OK = 0
    # Not a number, a quaternion that is not of unit length, or beyond `ABSURD`.
    NOT_FINITE = 1
    # Its time has not advanced.
    STALE = 2
    # It repeats itself to the last bit although it is to have moved by `RESOLUTION`.
    FROZEN = 3
    # It neither follows from the last one nor is where the prediction may be.
    JUMP = 4


ABSURD = 1e4
"""m, rad, m/s or rad/s: no vehicle is there, and none is so fast."""

UNIT_LENGTH = 0.1
"""How far the length of a quaternion may be off 1; that of the plant drifts a little."""

RESOLUTION = np.array([3e-4, 3e-4, 1e-3])
"""m, rad, rad: what moves by as much cannot give the same numbers again."""

DEVIATIONS = 8.0
"""Of the noise, as its standard deviations add up, that are believed."""

FOLLOWS = 3
"""Samples: one that comes no later than so many after the last is to follow from it."""

ACCELERATION = np.array([60.0, 300.0, 600.0])
"""m/s^2, rad/s^2, rad/s^2: what the vehicle can do at the most, from one sample to the next."""

SLACK = np.array([0.05, 0.02, 0.05])
"""m, rad, rad: how far a prediction may be off from the first."""

RATE_SLACK = np.array([1.0, 1.0, 3.0])
"""m/s, rad/s, rad/s: likewise of velocities."""

DRIFT = np.array([0.4, 1.5, 8.0])
"""m/s^2, rad/s^2, rad/s^2: how far off modelled accelerations may be, at first. Each second
of an outage adds as much again, so that no drift stays ahead of its bound."""

DRIFT_SHARE = 0.25
"""Of the disturbance that was known, by which it may change: what is strong also varies."""


class SampleCheck(NamedTuple):
    """What bounds the steps and innovations of samples, by group.

    A sample is believed if it *follows* from the last one that was, by the mean of both
    velocities and what an acceleration can add: this holds however wrong a model is. After
    a few that did not, one is believed that is where the *prediction* may be, by a
    bound that grows with the time of the outage. So no step is believed at once, and
    a lasting one when the prediction can be as wrong: 0.5 m after 1.3 s, 0.5 rad after
    0.7 s, in still air.

    Attributes:
        noise: (3,) m, rad, rad: what noise may do to a value.
        rate_noise: (3,) m/s, rad/s, rad/s: likewise of its velocity.
        dt: s, between samples.
    """

    noise: np.ndarray
    rate_noise: np.ndarray
    dt: float

    @classmethod
    def make(cls, config: Filter, sensors: Sensors, dt: float) -> SampleCheck:
        """For the noise that the filter expects, or that of the sensors if it is more; dt in s."""
        noise = np.maximum(
            [config.position_noise_m, config.attitude_noise_rad, config.joint_noise_rad],
            [sensors.position_noise_m, sensors.attitude_noise_rad, sensors.joint_noise_rad],
        )
        rate_noise = np.maximum(
            [config.velocity_noise_m_s, config.rate_noise_rad_s, 0.0],
            [sensors.velocity_noise_m_s, sensors.rate_noise_rad_s, 0.0],
        )
        return cls(DEVIATIONS * noise, DEVIATIONS * rate_noise, dt)


def initial_memory(sample: np.ndarray, stamp: float) -> np.ndarray:
    """(2 m + 6,) of a sample (m,): all is well with it, of the time `stamp` s.

    [the sample that came last, of each group the one that was believed last, the
    groups' times (3), how far each should have gone since its numbers changed (3)].
    """
    return np.concatenate([sample, sample, np.full(3, stamp), np.zeros(3)])


@compiled
def check(
    bounds: SampleCheck,
    memory: np.ndarray,
    ages: np.ndarray,
    predicted: np.ndarray,
    sample: np.ndarray,
    stamps: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Judges a sample.

    Args:
        bounds: Of what is believed.
        memory: (2 m + 6,) as `initial_memory` has it.
        ages: (3,) s, of the groups: from the last believed sample to the one before this.
        predicted: (6 + m,) the estimate, as `StateFilter` has it, of what it should be.
        sample: (m,) as it came.
        stamps: (3,) s, when each group of it was taken.

    Returns:
        (6,) ages now, 0 of what is believed, and the verdicts; the memory now.
    """
    m = len(sample)
    last, last_stamps = memory[:m], memory[2 * m : 2 * m + 3]
    now, health = memory.copy(), np.empty(6)
    believed, travel = now[m : 2 * m], now[2 * m + 3 :]
    disturbances = np.concatenate((predicted[:6], np.zeros(3)))  # None is known of joints.
    for g in range(3):
        since = ages[g] + bounds.dt
        x, rate = group_of(g, sample)
        x_last, rate_last = group_of(g, last)
        x_believed, rate_believed = group_of(g, believed)
        x_predicted, rate_predicted = group_of(g, predicted[6:])
        if np.all(x == x_last) and np.all(rate == rate_last):
            travel[g] += bounds.dt * max(length(rate), length(rate_predicted))
        else:
            travel[g] = 0.0

        if not last_stamps[g] < stamps[g] < np.inf:
            verdict = Verdict.STALE
        elif not _is_sound(g, x, rate):
            verdict = Verdict.NOT_FINITE
        elif travel[g] > RESOLUTION[g]:
            verdict = Verdict.FROZEN
        else:
            if not is_outage(bounds, ages[g]):
                step = _difference(g, x_believed, x) - since / 2 * (rate_believed + rate)
                is_ok = _follows(bounds, g, since, length(step), length(rate - rate_believed))
            else:
                known = length(disturbances[3 * g : 3 * g + 3])
                off = length(_difference(g, x_predicted, x))
                is_ok = _is_near(bounds, g, since, known, off, length(rate - rate_predicted))
            verdict = Verdict.OK if is_ok else Verdict.JUMP
        if verdict == Verdict.OK:
            since = 0.0
            x_believed[:] = x
            rate_believed[:] = rate
        health[g], health[3 + g] = since, verdict.value
    now[:m] = sample
    for g in range(3):
        # A time that is no number is not remembered: none would come after it.
        if np.isfinite(stamps[g]):
            now[2 * m + g] = stamps[g]
    return health, now


@compiled
def is_outage(bounds: SampleCheck, age: float) -> bool:
    """Whether a group has been missing for so long that none can follow from its last.

    Args:
        bounds: Of which dt.
        age: s, from the last that was believed to the sample before this one.
    """
    return age > (FOLLOWS - 0.5) * bounds.dt


@compiled
def _follows(bounds: SampleCheck, g: int, since: float, step: float, speeding: float) -> bool:
    """Whether a sample can come after the last that was believed.

    Args:
        bounds: Of noise.
        g: Group.
        since: s, from that one.
        step: Between them, beyond what the mean of both velocities makes.
        speeding: Between their velocities.
    """
    noise, rate_noise, a = bounds.noise[g], bounds.rate_noise[g], ACCELERATION[g]
    is_there = step <= 2 * noise + since * rate_noise + a * since**2 / 4
    return is_there and speeding <= 2 * rate_noise + a * since


@compiled
def _is_near(
    bounds: SampleCheck, g: int, since: float, known: float, off: float, rate_off: float
) -> bool:
    """Whether a sample is so far off its prediction, in value and velocity, as this may be.

    Args:
        bounds: Of noise.
        g: Group.
        since: s, how long it has been predicted.
        known: m/s^2 or rad/s^2, the disturbance that the prediction goes on with.
        off, rate_off: The distances.
    """
    a = DRIFT[g] + DRIFT_SHARE * known
    drift, rate_drift = a * since**2 / 2 + a * since**3 / 6, a * since + a * since**2 / 2
    is_there = off <= SLACK[g] + bounds.noise[g] + drift
    return is_there and rate_off <= RATE_SLACK[g] + bounds.rate_noise[g] + rate_drift


@compiled
def _is_sound(g: int, x: np.ndarray, rate: np.ndarray) -> bool:
    size = length(x)
    return (size < ABSURD if g != ATTITUDE else abs(size - 1) < UNIT_LENGTH) and length(
        rate
    ) < ABSURD


@compiled
def _difference(g: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How a becomes b; of quaternions, as a rotation vector in the world."""
    return rotation_vector(product(b, conjugate(a))) if g == ATTITUDE else b - a

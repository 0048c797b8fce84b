"""Sample check: accepts every plausible motion, and rejects what a vehicle cannot do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.estimate import Estimate
from aerodrake.model.sensing.sample import GROUPS, POSITION, Sample, group_columns
from aerodrake.model.sensing.sample_check import (
    ACCELERATION,
    DRIFT,
    RESOLUTION,
    SLACK,
    CheckState,
    SampleCheck,
    check,
)
from aerodrake.model.sensing.sample_health import SampleHealth, Verdict, split_health
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Filter, Sensors

DT = 0.01
JOINTS = 6
BOUNDS = SampleCheck.make(Filter(), Sensors(), DT)

each = pytest.mark.parametrize("g", range(len(GROUPS)))
unit = arrays(float, 3, elements=st.floats(-1, 1)).filter(lambda v: np.linalg.norm(v) > 0.1)


def moved(g: int, along: np.ndarray, value: float = 0.0, rate: float = 0.0) -> np.ndarray:
    """Returns a state at rest but for a group that has moved, and moves, along a vector."""
    e = along / np.linalg.norm(along)
    still = split_state(np.zeros(VehicleState.size(JOINTS)))
    still = still._replace(quaternion=np.array([1.0, 0, 0, 0]))
    joints = np.append(e, np.zeros(JOINTS - 3))
    turn = Rotation.from_rotvec(value * e).as_quat(scalar_first=True)
    return (
        still._replace(p_B=value * e, v_B=rate * e),
        still._replace(quaternion=turn, omega_W=rate * e),
        still._replace(q=value * joints, qdot=rate * joints),
    )[g].to_vector()


class Stream:
    """A sequence of samples, each with its own prediction, from rest."""

    def __init__(self, bounds: SampleCheck = BOUNDS):
        self.bounds = bounds
        self.stamp = 0.0
        self.state = CheckState.accepting(moved(0, np.ones(3)), self.stamp)

    def check(
        self, sample: np.ndarray, predicted: np.ndarray, stamps: np.ndarray | None = None
    ) -> list[Verdict]:
        """Returns the verdicts on the next sample."""
        self.stamp += DT
        stamps = np.full(3, self.stamp) if stamps is None else stamps
        estimate = Estimate(np.zeros(6), predicted)
        self.state = check(self.bounds, self.state, estimate, Sample(sample, stamps))
        return [Verdict(int(v)) for v in self.health.verdicts]

    @property
    def health(self) -> SampleHealth:
        return split_health(self.state.health)


def alone(g: int, verdict: Verdict) -> list[Verdict]:
    """Returns the verdict on one group, and OK on the others."""
    return [verdict if k == g else Verdict.OK for k in range(len(GROUPS))]


@each
@given(along=unit, a=arrays(float, 60, elements=st.floats(-1, 1)))
def test_any_motion_within_the_accelerations_is_accepted_without_a_prediction(g, along, a):
    """Accelerations are constant between samples; the prediction is far off."""
    stream, predicted, x, v = Stream(), moved(g, along, 1.5), 0.0, 0.0
    for ratio in a:
        acceleration = 0.99 * ratio * ACCELERATION[g]
        x, v = x + DT * v + DT**2 / 2 * acceleration, v + DT * acceleration
        assert stream.check(moved(g, along, x, v), predicted)[g] == Verdict.OK


@each
@given(draws=arrays(float, (50, 6), elements=st.floats(-4, 4)), size=st.floats(1e-6, 0.2))
def test_noise_of_the_configured_size_is_accepted(g, draws, size):
    """Up to four standard deviations on each axis, of a sample and the previous one."""
    noisy = Sensors(size, size, size, size, size)
    stream = Stream(SampleCheck.make(Filter(), noisy, DT))
    for k, draw in enumerate(size * draws):
        draw = draw + 1e-9 * (k + 1)  # So that no noise repeats.
        sample = moved(g, draw[:3], np.linalg.norm(draw[:3]))
        if g < 2:  # Rates of joints have no noise.
            columns = group_columns(GROUPS[g], JOINTS)[-3:]
            sample[columns] = draw[3:]
        assert stream.check(sample, moved(g, np.ones(3)))[g] == Verdict.OK, k


@each
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e12])
def test_a_group_with_one_nan_or_infinite_number_is_rejected_alone(g, wrong):
    sound = moved(g, np.ones(3))
    for column in group_columns(GROUPS[g], JOINTS):
        sample = sound.copy()
        sample[column] = wrong
        assert Stream().check(sample, sound) == alone(g, Verdict.NOT_FINITE)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5, 1e-200])
def test_a_quaternion_far_from_unit_length_is_rejected(factor):
    sample = moved(1, np.ones(3))
    sample[:4] *= factor
    assert Stream().check(sample, moved(1, np.ones(3))) == alone(1, Verdict.NOT_FINITE)


@given(along=unit, angle=st.floats(0, 0.05))
def test_a_quaternion_may_change_its_sign(along, angle):
    sample = moved(1, along, angle)
    sample[:4] *= -1
    assert Stream().check(sample, moved(1, along, angle))[1] == Verdict.OK


@each
@pytest.mark.parametrize("stamp", [0.0, -1.0, np.nan, np.inf, -np.inf])
def test_a_time_stamp_that_has_not_advanced_is_stale_and_a_later_one_is_not(g, stamp):
    stream, still = Stream(), moved(g, np.ones(3))
    stamps = np.full(3, DT)
    stamps[g] = stamp
    assert stream.check(still, still, stamps) == alone(g, Verdict.STALE)
    assert stream.check(still, still) == alone(g, Verdict.OK)


@each
def test_rest_is_not_frozen_however_long(g):
    stream, still = Stream(), moved(g, np.ones(3))
    for _ in range(1000):
        assert stream.check(still, still) == alone(g, Verdict.OK)


@each
@given(along=unit, speed=st.floats(0.01, 1.0))
@pytest.mark.parametrize("moving", ["sample", "prediction"])
def test_a_repeated_sample_is_frozen_once_it_should_have_moved(g, along, speed, moving):
    """At its own velocity, or at that of its prediction."""
    stream = Stream()
    sample = moved(g, along, 0.0, speed if moving == "sample" else 0.0)
    predicted = moved(g, along, 0.0, speed)
    stream.check(sample, predicted)
    stream.state.travel[:] = 0.0  # The first may repeat the initial sample.
    repeats = 0
    while stream.check(sample, predicted)[g] == Verdict.OK:
        repeats += 1
    assert stream.health.verdicts[g] == Verdict.FROZEN
    assert repeats * DT * speed <= RESOLUTION[g] * (1 + 1e-9)
    # Until its values change.
    assert stream.check(sample, predicted)[g] == Verdict.FROZEN
    assert stream.check(moved(g, along, 1e-6, speed), predicted)[g] == Verdict.OK


@each
@given(along=unit, size=st.floats(0.15, 3.0))
def test_a_step_is_rejected_until_the_prediction_can_be_as_wrong(g, along, size):
    """A later step back is too. A step of the position resets the filter."""
    stream, still, away = Stream(), moved(g, along), moved(g, along, size)
    growth = np.array([0.5, 1 / 6])
    for k in range(1, 1000):
        # Different values each time, so that they are not frozen.
        verdict = stream.check(moved(g, along, size + 1e-9 * k), still)[g]
        t = k * DT
        bound = SLACK[g] + BOUNDS.noise[g] + DRIFT[g] * growth @ [t**2, t**3]
        if verdict != Verdict.JUMP:
            break
        np.testing.assert_allclose(stream.health.ages[g], t)
    assert verdict == (Verdict.RESET if g == POSITION else Verdict.OK) and k > 3
    lasts = g == POSITION and size <= Filter().reset_m + bound and t >= Filter().reset_after_s
    assert lasts or bound >= size - 1e-6
    assert stream.health.ages[g] == 0 and stream.state.jump.duration_s == 0
    assert stream.check(still, away)[g] == Verdict.JUMP


@each
@given(along=unit, outage=st.integers(1, 300), ratio=st.floats(0, 1))
def test_after_an_outage_a_sample_within_the_drift_is_accepted_at_once(g, along, outage, ratio):
    stream, still = Stream(), moved(g, along)
    for _ in range(outage):
        stream.check(np.full(len(still), np.nan), still)
    np.testing.assert_allclose(stream.health.ages, outage * DT)
    t = (outage + 1) * DT
    if outage < 3:
        truth = moved(g, along, ratio * ACCELERATION[g] * t**2 / 4)
    else:
        truth = moved(g, along, ratio * (SLACK[g] + DRIFT[g] * t**2 / 2) * (1 - 1e-9))
    if np.max(np.abs(truth)) < 3:  # Larger angles are ambiguous.
        assert stream.check(truth, still) == [Verdict.OK] * 3
        np.testing.assert_array_equal(stream.state.health, 0)


def test_strong_disturbances_may_change_more():
    """In wind larger errors of a prediction are tolerated."""
    far = moved(0, np.ones(3), 0.5)
    verdicts = []
    for d in (0.0, 8.0):
        state = CheckState.accepting(moved(0, np.ones(3)), 0.0)
        for k in range(1, 60):
            sample = far if k == 59 else np.full(len(far), np.nan)
            estimate = Estimate(np.array([d, 0, 0, 0, 0, 0]), moved(0, np.ones(3)))
            state = check(BOUNDS, state, estimate, Sample(sample, np.full(3, k * DT)))
        verdicts.append(split_health(state.health).verdicts[0])
    assert verdicts == [Verdict.JUMP, Verdict.OK]


def test_health_is_split_into_ages_and_verdicts():
    health = np.array([0.1, 0.2, 0.3, 0.0, 3.0, 4.0])
    ages, verdicts = split_health(health)
    np.testing.assert_array_equal(ages, health[:3])
    np.testing.assert_array_equal(verdicts, health[3:])

"""What is believed of samples: whatever a vehicle may do, and nothing that it cannot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import GROUPS, group_columns
from aerodrake.model.sensing.sample_check import (
    ACCELERATION,
    DRIFT,
    RESOLUTION,
    SLACK,
    SampleCheck,
    Verdict,
    check,
    initial_memory,
)
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Filter, Sensors

DT = 0.01
JOINTS = 6
BOUNDS = SampleCheck.make(Filter(), Sensors(), DT)

each = pytest.mark.parametrize("g", range(len(GROUPS)))
unit = arrays(float, 3, elements=st.floats(-1, 1)).filter(lambda v: np.linalg.norm(v) > 0.1)


def moved(g: int, along: np.ndarray, value: float = 0.0, rate: float = 0.0) -> np.ndarray:
    """(13 + 2 n,) a sample, at rest but for a group that has moved, and moves, along a vector."""
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
    """Samples one after another, each with its own prediction; at first the vehicle is at rest."""

    def __init__(self, bounds: SampleCheck = BOUNDS):
        self.bounds = bounds
        self.stamp = 0.0
        self.health = np.zeros(6)
        self.memory = initial_memory(moved(0, np.ones(3)), self.stamp)

    def judge(
        self, sample: np.ndarray, predicted: np.ndarray, stamps: np.ndarray | None = None
    ) -> list[Verdict]:
        self.stamp += DT
        stamps = np.full(3, self.stamp) if stamps is None else stamps
        estimate = np.append(np.zeros(6), predicted)
        self.health, self.memory = check(
            self.bounds, self.memory, self.health[:3], estimate, sample, stamps
        )
        return [Verdict(int(v)) for v in self.health[3:]]


def alone(g: int, verdict: Verdict) -> list[Verdict]:
    """That verdict of one group, and well of the others."""
    return [verdict if k == g else Verdict.OK for k in range(len(GROUPS))]


@each
@given(along=unit, a=arrays(float, 60, elements=st.floats(-1, 1)))
def test_any_motion_within_the_accelerations_is_believed_without_any_prediction(g, along, a):
    """Held from sample to sample; the prediction is lost somewhere."""
    stream, nowhere, x, v = Stream(), moved(g, along, 1.5), 0.0, 0.0
    for share in a:
        h = 0.99 * share * ACCELERATION[g]
        x, v = x + DT * v + DT**2 / 2 * h, v + DT * h
        assert stream.judge(moved(g, along, x, v), nowhere)[g] == Verdict.OK


@each
@given(draws=arrays(float, (50, 6), elements=st.floats(-4, 4)), size=st.floats(1e-6, 0.2))
def test_noise_of_the_asked_size_is_believed(g, draws, size):
    """To four standard deviations on each axis, of a sample and the one before."""
    noisy = Sensors(size, size, size, size, size)
    stream = Stream(SampleCheck.make(Filter(), noisy, DT))
    for k, draw in enumerate(size * draws):
        draw = draw + 1e-9 * (k + 1)  # Lest the same noise come again.
        sample = moved(g, draw[:3], np.linalg.norm(draw[:3]))
        if g < 2:  # Rates of joints have no noise.
            columns = group_columns(GROUPS[g], JOINTS)[-3:]
            sample[columns] = draw[3:]
        assert stream.judge(sample, moved(g, np.ones(3)))[g] == Verdict.OK, k


@each
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e12])
def test_a_group_with_one_number_that_is_none_is_refused_alone(g, wrong):
    sound = moved(g, np.ones(3))
    for column in group_columns(GROUPS[g], JOINTS):
        sample = sound.copy()
        sample[column] = wrong
        assert Stream().judge(sample, sound) == alone(g, Verdict.NOT_FINITE)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5, 1e-200])
def test_a_quaternion_far_from_unit_length_is_no_attitude(factor):
    sample = moved(1, np.ones(3))
    sample[:4] *= factor
    assert Stream().judge(sample, moved(1, np.ones(3))) == alone(1, Verdict.NOT_FINITE)


@given(along=unit, angle=st.floats(0, 0.05))
def test_a_quaternion_may_change_its_sign(along, angle):
    sample = moved(1, along, angle)
    sample[:4] *= -1
    assert Stream().judge(sample, moved(1, along, angle))[1] == Verdict.OK


@each
@pytest.mark.parametrize("stamp", [0.0, -1.0, np.nan, np.inf, -np.inf])
def test_a_time_that_has_not_advanced_is_stale_and_a_later_one_is_not(g, stamp):
    stream, still = Stream(), moved(g, np.ones(3))
    stamps = np.full(3, DT)
    stamps[g] = stamp
    assert stream.judge(still, still, stamps) == alone(g, Verdict.STALE)
    assert stream.judge(still, still) == alone(g, Verdict.OK)


@each
def test_rest_is_not_frozen_however_long(g):
    stream, still = Stream(), moved(g, np.ones(3))
    for _ in range(1000):
        assert stream.judge(still, still) == alone(g, Verdict.OK)


@each
@given(along=unit, speed=st.floats(0.01, 1.0))
@pytest.mark.parametrize("says", ["sample", "prediction"])
def test_what_repeats_itself_is_frozen_when_it_is_to_have_moved(g, along, speed, says):
    """By its own velocity, or by that of its prediction."""
    stream = Stream()
    sample = moved(g, along, 0.0, speed if says == "sample" else 0.0)
    predicted = moved(g, along, 0.0, speed)
    stream.judge(sample, predicted)
    stream.memory[-3:] = 0.0  # The first may repeat what was there before.
    late = 0
    while stream.judge(sample, predicted)[g] == Verdict.OK:
        late += 1
    assert stream.health[3 + g] == Verdict.FROZEN
    assert late * DT * speed <= RESOLUTION[g] * (1 + 1e-9)
    # And until its numbers change.
    assert stream.judge(sample, predicted)[g] == Verdict.FROZEN
    assert stream.judge(moved(g, along, 1e-6, speed), predicted)[g] == Verdict.OK


@each
@given(along=unit, size=st.floats(0.15, 3.0))
def test_a_step_is_refused_until_the_prediction_may_be_as_wrong(g, along, size):
    """And so is the step back, if it comes later than that."""
    stream, still, away = Stream(), moved(g, along), moved(g, along, size)
    growth = np.array([0.5, 1 / 6])
    for k in range(1, 1000):
        # Another number each time, lest it be frozen.
        verdict = stream.judge(moved(g, along, size + 1e-9 * k), still)[g]
        t = k * DT
        bound = SLACK[g] + BOUNDS.noise[g] + DRIFT[g] * growth @ [t**2, t**3]
        if verdict == Verdict.OK:
            break
        np.testing.assert_allclose(stream.health[g], t)
    assert verdict == Verdict.OK and k > 3 and bound >= size - 1e-6
    assert stream.health[g] == 0
    assert stream.judge(still, away)[g] == Verdict.JUMP


@each
@given(along=unit, outage=st.integers(1, 300), share=st.floats(0, 1))
def test_after_an_outage_a_sample_within_the_drift_is_believed_at_once(g, along, outage, share):
    stream, still = Stream(), moved(g, along)
    for _ in range(outage):
        stream.judge(np.full(len(still), np.nan), still)
    np.testing.assert_allclose(stream.health[:3], outage * DT)
    t = (outage + 1) * DT
    if outage < 3:
        truth = moved(g, along, share * ACCELERATION[g] * t**2 / 4)
    else:
        truth = moved(g, along, share * (SLACK[g] + DRIFT[g] * t**2 / 2) * (1 - 1e-9))
    if np.max(np.abs(truth)) < 3:  # Angles beyond half a turn are others.
        assert stream.judge(truth, still) == [Verdict.OK] * 3
        np.testing.assert_array_equal(stream.health, 0)


def test_strong_disturbances_may_change_more():
    """In wind a prediction is further off, and is believed to be."""
    far = moved(0, np.ones(3), 0.5)
    verdicts = []
    for d in (0.0, 8.0):
        health, memory = np.zeros(6), initial_memory(moved(0, np.ones(3)), 0.0)
        for k in range(1, 60):
            sample = far if k == 59 else np.full(len(far), np.nan)
            estimate = np.concatenate([[d, 0, 0, 0, 0, 0], moved(0, np.ones(3))])
            health, memory = check(BOUNDS, memory, health[:3], estimate, sample, np.full(3, k * DT))
        verdicts.append(health[3])
    assert verdicts == [Verdict.JUMP, Verdict.OK]

"""Tests of reference faults, alone and together."""

import numpy as np

from aerodrake.model.reference.fault import with_faults
from aerodrake.scenario import Push, ReferenceDrift, ReferenceJump, ReferenceNan

TIMES = np.arange(0.0, 4.0, 0.5)
MOTION = np.outer(TIMES, [1.0, 2.0, 3.0]), np.tile([1.0, 2.0, 3.0], (len(TIMES), 1))
JUMP = ReferenceJump(start_s=1.0, duration_s=1.0, offset_m=(0.5, 0.0, -0.5))
DRIFT = ReferenceDrift(start_s=1.5, duration_s=2.0, velocity_m_s=(0.0, 2.0, 0.0))


def read_now(faults) -> tuple[np.ndarray, np.ndarray]:
    """Returns the motion at `TIMES`, each row read at its own time."""
    rows = [
        with_faults(faults, t, TIMES[i : i + 1], (MOTION[0][i : i + 1], MOTION[1][i : i + 1]))
        for i, t in enumerate(TIMES)
    ]
    return tuple(np.vstack(part) for part in zip(*rows, strict=True))


def test_faults_are_active_from_their_start_until_before_their_end():
    p, v = read_now([JUMP, DRIFT, Push()])
    moved = p - MOTION[0]
    on = (TIMES >= 1.0) & (TIMES < 2.0)
    np.testing.assert_allclose(moved[:, 0], 0.5 * on)
    np.testing.assert_allclose(moved[:, 2], -0.5 * on)
    drifts = (TIMES >= 1.5) & (TIMES < 3.5)
    np.testing.assert_allclose(moved[:, 1], np.where(drifts, 2.0 * (TIMES - 1.5), 0))
    np.testing.assert_allclose(v[:, 1] - 2.0, 2.0 * drifts)


def test_a_fault_affects_the_whole_horizon_once_it_is_active():
    for now, is_active in ((0.9, False), (1.0, True), (1.9, True), (2.0, False)):
        p, _ = with_faults([JUMP], now, now + TIMES, MOTION)
        np.testing.assert_allclose(p[:, 0] - MOTION[0][:, 0], 0.5 * is_active)


def test_nan_stays_nan_and_the_argument_is_not_changed():
    before = MOTION[0].copy()
    p, v = read_now([ReferenceNan(start_s=1.0, duration_s=1.0), JUMP])
    assert np.isnan(p[2:4]).all() and np.isnan(v[2:4]).all()
    assert np.isfinite(np.delete(p, [2, 3], axis=0)).all()
    np.testing.assert_array_equal(MOTION[0], before)

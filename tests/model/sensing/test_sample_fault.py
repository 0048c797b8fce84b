"""What each fault makes of a sample, and what it leaves alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import GROUPS, group_columns
from aerodrake.model.sensing.sample_fault import faulty
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import SampleFrozen, SampleJump, SampleNan, SampleStale

JOINTS = 6
SAMPLE = np.linspace(0.1, 2.0, VehicleState.size(JOINTS))
SAMPLE[:4] = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_quat(scalar_first=True)
HELD = -SAMPLE
STAMPS, HELD_STAMPS = np.array([1.0, 1.1, 1.2]), np.array([0.5, 0.6, 0.7])

either = pytest.mark.parametrize("group", [*GROUPS, "all"])


def struck(group: str) -> tuple[np.ndarray, np.ndarray]:
    """Whether it is each number of a sample, and each time."""
    columns = np.isin(np.arange(len(SAMPLE)), group_columns(group, JOINTS))
    return columns, np.array([group in (g, "all") for g in GROUPS])


def test_groups_are_parts_of_a_sample_and_together_all_of_it():
    joined = np.concatenate([group_columns(g, JOINTS) for g in GROUPS])
    assert sorted(joined) == sorted(group_columns("all", JOINTS)) == list(range(len(SAMPLE)))
    state = split_state(SAMPLE)
    for group, values in (
        ("position", [*state.p_B, *state.v_B]),
        ("attitude", [*state.quaternion, *state.omega_W]),
        ("joints", [*state.q, *state.qdot]),
    ):
        np.testing.assert_array_equal(SAMPLE[group_columns(group, JOINTS)], values)


@either
@pytest.mark.parametrize(
    ("kind", "expected", "times"),
    [
        (SampleNan, np.full(len(SAMPLE), np.nan), STAMPS),
        (SampleFrozen, HELD, STAMPS),
        (SampleStale, HELD, HELD_STAMPS),
    ],
)
def test_a_fault_strikes_its_group_alone(kind, expected, times, group):
    kept = SAMPLE.copy()
    found, stamps = faulty(kind(group=group), SAMPLE, STAMPS, HELD, HELD_STAMPS)
    columns, groups = struck(group)
    np.testing.assert_array_equal(found, np.where(columns, expected, SAMPLE))
    np.testing.assert_array_equal(stamps, np.where(groups, times, STAMPS))
    np.testing.assert_array_equal(SAMPLE, kept)


@either
@given(position=st.floats(-5, 5), angle=st.floats(-3, 3))
def test_a_jump_is_of_the_asked_size(group, position, angle):
    fault = SampleJump(group=group, position_m=position, angle_rad=angle)
    found, stamps = faulty(fault, SAMPLE, STAMPS, HELD, HELD_STAMPS)
    columns, _ = struck(group)
    np.testing.assert_array_equal(found[~columns], SAMPLE[~columns])
    np.testing.assert_array_equal(stamps, STAMPS)
    was, now = split_state(SAMPLE), split_state(found)
    if group in ("position", "all"):
        np.testing.assert_allclose(now.p_B - was.p_B, position / np.sqrt(3), atol=1e-12)
    if group in ("attitude", "all"):
        turn = Rotation.from_matrix(was.R_B.T @ now.R_B)
        np.testing.assert_allclose(turn.as_rotvec(), angle / np.sqrt(3), atol=1e-9)
    if group in ("joints", "all"):
        np.testing.assert_allclose(now.q - was.q, angle, atol=1e-12)
    for key in ("v_B", "omega_W", "qdot"):
        np.testing.assert_array_equal(getattr(now, key), getattr(was, key))

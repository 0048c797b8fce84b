"""Effect of each fault on a sample: the faulty group changes, the others do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import GROUPS, Sample, group_columns
from aerodrake.model.sensing.sample_fault import faulty
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import SampleFrozen, SampleJump, SampleNan, SampleStale

JOINTS = 6
STATE = np.linspace(0.1, 2.0, VehicleState.size(JOINTS))
STATE[:4] = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_quat(scalar_first=True)
SAMPLE = Sample(STATE, np.array([1.0, 1.1, 1.2]))
LAST = Sample(-STATE, np.array([0.5, 0.6, 0.7]))

either = pytest.mark.parametrize("group", [*GROUPS, "all"])


def faulty_parts(group: str) -> tuple[np.ndarray, np.ndarray]:
    """Returns masks of the values and the time stamps that belong to a group."""
    columns = np.isin(np.arange(len(STATE)), group_columns(group, JOINTS))
    return columns, np.array([group in (g, "all") for g in GROUPS])


def test_groups_are_parts_of_a_sample_and_together_all_of_it():
    joined = np.concatenate([group_columns(g, JOINTS) for g in GROUPS])
    assert sorted(joined) == sorted(group_columns("all", JOINTS)) == list(range(len(STATE)))
    state = split_state(STATE)
    for group, values in (
        ("position", [*state.p_B, *state.v_B]),
        ("attitude", [*state.quaternion, *state.omega_W]),
        ("joints", [*state.q, *state.qdot]),
    ):
        np.testing.assert_array_equal(STATE[group_columns(group, JOINTS)], values)


@either
@pytest.mark.parametrize(
    ("kind", "expected", "times"),
    [
        (SampleNan, np.full(len(STATE), np.nan), SAMPLE.stamps),
        (SampleFrozen, LAST.state, SAMPLE.stamps),
        (SampleStale, LAST.state, LAST.stamps),
    ],
)
def test_a_fault_changes_its_group_alone(kind, expected, times, group):
    original = STATE.copy()
    state, stamps = faulty(kind(group=group), SAMPLE, LAST)
    columns, groups = faulty_parts(group)
    np.testing.assert_array_equal(state, np.where(columns, expected, STATE))
    np.testing.assert_array_equal(stamps, np.where(groups, times, SAMPLE.stamps))
    np.testing.assert_array_equal(STATE, original)


@either
@given(position=st.floats(-5, 5), angle=st.floats(-3, 3))
def test_a_jump_has_the_configured_size(group, position, angle):
    fault = SampleJump(group=group, position_m=position, angle_rad=angle)
    state, stamps = faulty(fault, SAMPLE, LAST)
    columns, _ = faulty_parts(group)
    np.testing.assert_array_equal(state[~columns], STATE[~columns])
    np.testing.assert_array_equal(stamps, SAMPLE.stamps)
    before, after = split_state(STATE), split_state(state)
    if group in ("position", "all"):
        np.testing.assert_allclose(after.p_B - before.p_B, position / np.sqrt(3), atol=1e-12)
    if group in ("attitude", "all"):
        turn = Rotation.from_matrix(before.R_B.T @ after.R_B)
        np.testing.assert_allclose(turn.as_rotvec(), angle / np.sqrt(3), atol=1e-9)
    if group in ("joints", "all"):
        np.testing.assert_allclose(after.q - before.q, angle, atol=1e-12)
    for key in ("v_B", "omega_W", "qdot"):
        np.testing.assert_array_equal(getattr(after, key), getattr(before, key))

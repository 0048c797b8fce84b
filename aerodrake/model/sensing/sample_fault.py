"""Effect of a fault on samples."""

import numpy as np
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import GROUPS, Sample, group_columns
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import SampleFault, SampleFrozen, SampleJump, SampleNan, SampleStale

DIAGONAL = np.ones(3) / np.sqrt(3)
"""Unit vector (3,) along which positions and attitudes jump."""


def faulty(fault: SampleFault, sample: Sample, last: Sample) -> Sample:
    """Returns a sample as it arrives during a fault.

    Positions jump along the diagonal (1, 1, 1) of the world, attitudes turn about that of the
    base; each joint jumps by the whole angle.

    Args:
        fault: Fault of one group, or of all.
        sample: As measured.
        last: The last sample before the fault.
    """
    state, stamps = sample.state.copy(), sample.stamps.copy()
    n = (len(state) - VehicleState.size(0)) // 2
    columns = group_columns(fault.group, n)
    match fault:
        case SampleNan():
            state[columns] = np.nan
        case SampleStale():
            state[columns] = last.state[columns]
            is_stale = [fault.group in ("all", group) for group in GROUPS]
            stamps[is_stale] = last.stamps[is_stale]
        case SampleFrozen():
            state[columns] = last.state[columns]
        case SampleJump():
            state[columns] = _jumped(fault, sample.state)[columns]
    return Sample(state, stamps)


def _jumped(fault: SampleJump, state: np.ndarray) -> np.ndarray:
    """Returns a state (13 + 2 n,) with a step of each group."""
    jumped = state.copy()
    parts = split_state(jumped)
    parts.p_B[:] += fault.position_m * DIAGONAL
    parts.q[:] += fault.angle_rad
    turn = Rotation.from_rotvec(fault.angle_rad * DIAGONAL)
    attitude = Rotation.from_quat(parts.quaternion, scalar_first=True)
    parts.quaternion[:] = (attitude * turn).as_quat(scalar_first=True)
    return jumped

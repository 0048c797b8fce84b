"""What a fault makes of samples."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import GROUPS, group_columns
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import SampleFault, SampleFrozen, SampleJump, SampleNan, SampleStale

DIAGONAL = np.ones(3) / np.sqrt(3)
"""(3,), of length 1: the direction in which positions and attitudes are off."""


def faulty(
    fault: SampleFault,
    sample: np.ndarray,
    stamps: np.ndarray,
    held: np.ndarray,
    held_stamps: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """A sample and its times as they arrive while a fault is there.

    Steps of position go along the diagonal (1, 1, 1) of the world, those of attitude
    turn about the base's; each joint is off by the whole angle.

    Args:
        fault: Of a group, or of all.
        sample: (13 + 2 n,) without it.
        stamps: (3,) s, when its groups were taken.
        held: (13 + 2 n,) the last sample before the fault.
        held_stamps: (3,) s, of that one.
    """
    found, times = sample.copy(), stamps.copy()
    n = (len(sample) - VehicleState.size(0)) // 2
    columns = group_columns(fault.group, n)
    match fault:
        case SampleNan():
            found[columns] = np.nan
        case SampleStale():
            found[columns] = held[columns]
            struck = [fault.group in ("all", group) for group in GROUPS]
            times[struck] = held_stamps[struck]
        case SampleFrozen():
            found[columns] = held[columns]
        case SampleJump():
            found[columns] = _stepped(fault, sample)[columns]
    return found, times


def _stepped(fault: SampleJump, sample: np.ndarray) -> np.ndarray:
    """(13 + 2 n,) a sample with each group off by its step."""
    found = sample.copy()
    state = split_state(found)
    state.p_B[:] += fault.position_m * DIAGONAL
    state.q[:] += fault.angle_rad
    turn = Rotation.from_rotvec(fault.angle_rad * DIAGONAL)
    attitude = Rotation.from_quat(state.quaternion, scalar_first=True)
    state.quaternion[:] = (attitude * turn).as_quat(scalar_first=True)
    return found

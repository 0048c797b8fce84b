"""Torque limits of joints that share inertia."""

import numpy as np

from aerodrake.support.compiled import compiled


@compiled
def within_limits(inertia: np.ndarray, desired: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Returns torques (n,) within their limits that keep the accelerations of the other joints.

    Joints are added to those at their limits one by one, each time the one that exceeds its limit
    the most in proportion, and the other torques are changed by `compensation`, until none exceeds.

    Args:
        inertia: (n, n) kg m^2, M.
        desired: (n,) N m, tau_d.
        limit: (n,) N m.
    """
    torque, at_limit = desired.copy(), np.zeros(len(desired), dtype=np.bool_)
    for _ in range(len(desired)):
        excess = np.where(at_limit, 0.0, np.abs(torque) - limit)
        if excess.max() <= 0:
            break
        worst = np.argmax(excess / np.maximum(limit, 1e-9))
        at_limit[worst] = True
        torque[worst] = min(max(torque[worst], -limit[worst]), limit[worst])
        changed = desired + compensation(inertia, at_limit, torque - desired)
        torque = np.where(at_limit, torque, changed)
    return torque


@compiled
def compensation(inertia: np.ndarray, at_limit: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Returns changes (n,) N m of all torques that leave the other accelerations as they are.

    With S the joints at their limits and U the others, that is the change of tau_S, and
    M_US M_SS^-1 times it for tau_U.

    Args:
        inertia: (n, n) kg m^2, M.
        at_limit: (n,) bool, S.
        change: (n,) N m, change of the torques of S; others are not used.
    """
    M_SS = np.eye(len(inertia))
    for i in np.flatnonzero(at_limit):
        M_SS[i] = np.where(at_limit, inertia[i], 0.0)
    return inertia @ np.linalg.solve(M_SS, np.where(at_limit, change, 0.0))

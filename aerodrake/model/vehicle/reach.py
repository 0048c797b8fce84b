"""How far the arm reaches."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel

STARTS = 32
"""Configurations from which the farthest one is searched."""


def farthest_reach(vehicle: VehicleModel) -> float:
    """The farthest that joint limits let the end-effector get from p_O, in m.

    The URDF's own answer to what the paper's d_edge stands for. Searched from
    random configurations, always the same.
    """
    kinematics = Kinematics(vehicle.robot)

    def closeness(q: np.ndarray) -> tuple[float, np.ndarray]:
        p_EB, J_B = kinematics.arm(q)
        offset = p_EB - vehicle.p_O
        return -offset @ offset / 2, -J_B.T @ offset

    spread = np.random.default_rng(0).random((STARTS, vehicle.joints))
    bounds = list(zip(vehicle.lower, vehicle.upper, strict=True))
    found = [
        minimize(closeness, q, jac=True, bounds=bounds, method="L-BFGS-B").fun
        for q in vehicle.lower + spread * (vehicle.upper - vehicle.lower)
    ]
    return float(np.sqrt(-2 * min(found)))

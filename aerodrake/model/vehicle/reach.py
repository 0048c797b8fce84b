"""Reach of the arm."""

import numpy as np
from scipy.optimize import minimize

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel

STARTS = 32
"""Number of random start configurations of the search."""


def farthest_reach(vehicle: VehicleModel) -> float:
    """Returns the largest distance of the end-effector from p_O within joint limits, in m.

    This is the URDF's value of the paper's d_edge. Found by local searches from random
    configurations, which are the same at every call.
    """
    kinematics = Kinematics(vehicle.plant)

    def negative_square(q: np.ndarray) -> tuple[float, np.ndarray]:
        p_EB, J_B = kinematics.arm(q)
        offset = p_EB - vehicle.p_O
        return -offset @ offset / 2, -J_B.T @ offset

    spread = np.random.default_rng(0).random((STARTS, vehicle.joints))
    bounds = list(zip(vehicle.lower, vehicle.upper, strict=True))
    minima = [
        minimize(negative_square, q, jac=True, bounds=bounds, method="L-BFGS-B").fun
        for q in vehicle.lower + spread * (vehicle.upper - vehicle.lower)
    ]
    return float(np.sqrt(-2 * min(minima)))

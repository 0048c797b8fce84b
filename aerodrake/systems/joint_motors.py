"""Motors of the joints with model mismatch."""

import numpy as np
from pydrake.symbolic import Variable, max, min
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mismatch
from aerodrake.support.arguments import checked


@checked
def make_joint_motors(mismatch: Mismatch, vehicle: VehicleModel) -> SymbolicVectorSystem | None:
    """Makes the motors as a system of Drake, with `mismatch.torque_scale`; None if it is 1.

    Ports:
        in `u0` (n): N m, commanded torques.
        out `y0` (n): N m, torques: their deviation from trim is scaled, then they are limited.

    Args:
        mismatch: The factor.
        vehicle: Trim and torque limits.
    """
    if mismatch.torque_scale == 1:
        return None
    command = [Variable(f"u{i}") for i in range(vehicle.joints)]
    trim, limit = vehicle.trim_torque, vehicle.effort
    scaled = [t + mismatch.torque_scale * (u - t) for u, t in zip(command, trim, strict=True)]
    output = [min(max(y, -most), most) for y, most in zip(scaled, limit, strict=True)]
    return SymbolicVectorSystem(input=np.array(command), output=np.array(output))

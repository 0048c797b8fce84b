"""Bounds of the states over the horizon."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.setpoint.integration import SetpointLimits


class StateBounds(NamedTuple):
    """Bounds of the states, the paper's set X.

    Bounded are the base *setpoint's* velocity (not the measured one) and joint positions and
    velocities at each stage, and the terminal braking distance: q + t_s q' within the position
    limits. With t_s = v_max / (2 a_max), which no joint exceeds, feasibility is recursive if the
    horizon lasts 2 t_s or longer and each stage is one tick. With longer stages it is
    not guaranteed: then bounds are `relaxed`, and the setpoint integrator enforces the limits.

    Attributes:
        index: (b,), bounded states.
        lower, upper: (b,).
        stop: (n, nx), maps the last state to q + t_s q'.
        stop_lower, stop_upper: (n,), position limits.
    """

    index: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    stop: np.ndarray
    stop_lower: np.ndarray
    stop_upper: np.ndarray

    @classmethod
    def make(cls, model: EquivalentModel, limits: SetpointLimits) -> Self:
        """Makes the bounds from the limits of the setpoints."""
        q, qdot = model.joint_position, model.joint_velocity
        stop = np.zeros((model.joints, len(model.A)))
        joint = np.arange(model.joints)
        stop[joint, q] = 1.0
        stop[joint, qdot] = limits.velocity[3:] / (2 * limits.acceleration[3:])
        return cls(
            np.concatenate([model.setpoint_velocity, q, qdot]),
            np.concatenate([-limits.velocity[:3], limits.lower[3:], -limits.velocity[3:]]),
            np.concatenate([limits.velocity[:3], limits.upper[3:], limits.velocity[3:]]),
            stop,
            limits.lower[3:],
            limits.upper[3:],
        )

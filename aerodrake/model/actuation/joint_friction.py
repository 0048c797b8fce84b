"""Coulomb and viscous friction of joints, with stiction, in discrete time."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation
from aerodrake.support.compiled import compiled

STIFFNESS, DAMPING = 0.1, 0.5
"""Stiffness and damping of a stuck joint, relative to inertia / period^2 and inertia / period.

The joint's rate then decays by the factor 0.7 a step, or more slowly if its inertia is larger. The
motion is stable for inertias down to 0.28 of the assumed one.
"""


class JointFriction(NamedTuple):
    """Friction of n joints, whose Coulomb part is an elastic element that slips.

    Before a joint slides, its friction torque is that of a stiff spring and a damper, as that of
    bearings and gears in presliding (Dupont et al. 2002, "Single state elastoplastic friction
    models"). The deflection of the spring is bounded by the Coulomb torque: a sliding joint has
    exactly this torque, a stuck one the torque that holds it, without drift. Stiffness and damping
    are as large as the stability of an explicit step permits, with a margin (`STIFFNESS`).

    Attributes:
        coulomb: (n,) N m.
        stiffness: (n,) N m/rad, of a stuck joint.
        damping: (n,) N m s/rad, of a stuck joint.
        viscous: (n,) N m s/rad, mean over a step in which viscous friction alone acts.
        dt: s.
    """

    coulomb: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    viscous: np.ndarray
    dt: float

    @classmethod
    def make(cls, config: Actuation, vehicle: VehicleModel, dt: float) -> Self:
        """Returns the friction of a vehicle's joints.

        Args:
            config: Coulomb and viscous friction.
            vehicle: Inertia of the arm.
            dt: s, period of the plant.

        Raises:
            ScenarioError: if a list of values has the wrong length.
        """
        inertia = smallest_inertia(vehicle.arm_inertia)
        viscous = vehicle.per_joint(config.viscous_n_m_s_rad, "actuation.viscous_n_m_s_rad")
        return cls(
            coulomb=vehicle.per_joint(config.coulomb_n_m, "actuation.coulomb_n_m").copy(),
            stiffness=STIFFNESS * inertia / dt**2,
            damping=DAMPING * inertia / dt,
            viscous=-np.expm1(-viscous * dt / inertia) * inertia / dt,
            dt=dt,
        )


def smallest_inertia(M: np.ndarray) -> np.ndarray:
    """Returns a diagonal (n,) D of inertias that is a lower bound of an inertia matrix M (n, n).

    All eigenvalues of D^1/2 M^-1 D^1/2 are at most 1; D is proportional to the inertia of each
    joint when all others move freely.
    """
    inverse = np.linalg.inv(M)
    free = 1 / np.diag(inverse)
    root = np.sqrt(free)
    return free / np.linalg.eigvalsh(root[:, None] * inverse * root)[-1]


@compiled
def deflection(friction: JointFriction, last: np.ndarray, qdot: np.ndarray) -> np.ndarray:
    """Returns the deflections (n,) rad of the springs now.

    Args:
        friction: The friction.
        last: (n,) rad, deflections one step ago.
        qdot: (n,) rad/s, velocities now.
    """
    most = friction.coulomb / friction.stiffness
    return np.minimum(np.maximum(last + friction.dt * qdot, -most), most)


@compiled
def friction_torque(friction: JointFriction, last: np.ndarray, qdot: np.ndarray) -> np.ndarray:
    """Returns the torques (n,) N m that friction exerts on the joints until the next step.

    Args:
        friction: The friction.
        last: (n,) rad, deflections of the springs one step ago.
        qdot: (n,) rad/s, velocities now.
    """
    stuck = friction.stiffness * deflection(friction, last, qdot) + friction.damping * qdot
    coulomb = np.minimum(np.maximum(stuck, -friction.coulomb), friction.coulomb)
    return -coulomb - friction.viscous * qdot

"""Positions and spin of a robot's rotors."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, RigidBody

from aerodrake.model.vehicle.rotation import UP
from aerodrake.support.errors import BadInput

ROTOR_PREFIX = "rotor_"
"""Prefix of the names of the rotors' frames in the URDF."""
SPINS = ("_ccw", "_cw")
"""Endings of these names: directions of rotation seen from above."""
PARALLEL = 1e-6
"""Largest distance between unit vectors that are taken for parallel."""
INDEPENDENT = 0.05
"""Smallest relative width of the rotors' positions, and smallest part of a row of the mixer that
is independent of the others. A vehicle below it has a twentieth of the usual torque."""


@dataclass(frozen=True)
class Rotors:
    """Positions and spin of the rotors.

    Attributes:
        names: Names of their frames, in the order of thrust vectors.
        p_B: (k, 3) m, their positions in the base frame.
        spin: (k,) +1 for propellers that turn counter-clockwise seen from above, else -1.
    """

    names: tuple[str, ...]
    p_B: np.ndarray
    spin: np.ndarray

    def mixer(self, torque_ratio: float) -> np.ndarray:
        """Returns the matrix (4, k) that maps thrusts in N to [collective thrust in N, torque
        about the base's x, y and z axes in N m].

        Args:
            torque_ratio: m, drag torque over thrust; the torque acts against the spin.
        """
        x, y, _ = self.p_B.T
        return np.vstack([np.ones_like(x), y, -x, -self.spin * torque_ratio])

    @classmethod
    def of(cls, plant: MultibodyPlant, base: RigidBody, robot: str) -> Self:
        """Reads the rotors from a plant.

        Args:
            plant: The plant, which contains the robot.
            base: The link that the rotors are fixed to.
            robot: URI or path of the robot, for messages.

        Raises:
            BadInput: if there are fewer than four, one is on another link or tilted, the name of
                its frame ends in neither `_ccw` nor `_cw`, or they cannot produce roll, pitch and
                yaw torque apart from each other and from lift.
        """
        frames = [plant.get_frame(i) for i in plant.GetFrameIndices(base.model_instance())]
        frames = [f for f in frames if f.name().startswith(ROTOR_PREFIX)]
        for f in frames:
            if problem := _frame_defect(f, base):
                raise BadInput(robot, f"frame {f.name()}", problem)
        names = ", ".join(f.name() for f in frames) or "none"
        if len(frames) < 4:
            problem = f"expected four or more frames rotor_*_ccw and rotor_*_cw, got {names}"
            raise BadInput(robot, "", problem)
        rotors = cls(
            names=tuple(f.name() for f in frames),
            p_B=np.array([f.GetFixedPoseInBodyFrame().translation() for f in frames]),
            spin=np.array([1.0 if f.name().endswith("_ccw") else -1.0 for f in frames]),
        )
        if problem := rotors.missing_torque():
            raise BadInput(robot, "", f"{problem}, got {names}")
        return rotors

    def missing_torque(self) -> str:
        """Returns the torque that no thrusts can produce on its own; empty if there is none.

        The rows of the mixer have to be linearly independent, with a margin of `INDEPENDENT`.
        """
        position = self.p_B[:, :2] - self.p_B[:, :2].mean(axis=0)
        length, width = np.linalg.svd(position, compute_uv=False)
        if width <= INDEPENDENT * length:
            return "expected rotors that are not on one line, for roll and pitch torque"
        others = np.column_stack([np.ones(len(self.spin)), position / length])
        projection = others @ np.linalg.lstsq(others, self.spin, rcond=None)[0]
        remainder = np.linalg.norm(self.spin - projection) / np.linalg.norm(self.spin)
        if remainder <= INDEPENDENT:
            return (
                "expected directions of rotation, _ccw and _cw, with which the rotors can produce "
                "yaw torque without lift, roll or pitch torque"
            )
        return ""


def _frame_defect(frame: Frame, base: RigidBody) -> str:
    """Returns the expectation that a rotor's frame does not fulfil; empty if there is none.

    A rotation about its own z axis, along the thrust, has no effect.
    """
    if not frame.name().endswith(SPINS):
        return f"expected a name that ends in {' or '.join(SPINS)}, its direction of rotation"
    if frame.body() != base:
        return f"expected the link {base.name()}, got {frame.body().name()}"
    z_axis = frame.GetFixedPoseInBodyFrame().rotation().col(2)
    if np.linalg.norm(z_axis - UP) > PARALLEL:
        got = ", ".join(f"{z:.3g}" for z in z_axis)
        return f"expected its z axis, the thrust's, along that of {base.name()}, got ({got})"
    return ""

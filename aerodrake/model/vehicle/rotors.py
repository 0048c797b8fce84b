"""Positions and spin of a robot's rotors."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from aerodrake.support.errors import BadInput

ROTOR_PREFIX = "rotor_"
"""Prefix of the names of the rotors' frames in the URDF."""


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
            BadInput: if there are fewer than four, one is on another link or tilted, or the name
                of its frame ends in neither `_ccw` nor `_cw`.
        """
        frames = [plant.get_frame(i) for i in plant.GetFrameIndices(base.model_instance())]
        frames = [f for f in frames if f.name().startswith(ROTOR_PREFIX)]
        if len(frames) < 4 or not all(f.name().endswith(("_ccw", "_cw")) for f in frames):
            raise BadInput(robot, "", "expected four or more frames rotor_*_ccw and rotor_*_cw")
        for f in frames:
            pose = f.GetFixedPoseInBodyFrame()
            if f.body() != base or not pose.rotation().IsNearlyIdentity(1e-6):
                raise BadInput(
                    robot, "", f"expected {f.name()} on the link {base.name()}, with its z axis"
                )
        return cls(
            names=tuple(f.name() for f in frames),
            p_B=np.array([f.GetFixedPoseInBodyFrame().translation() for f in frames]),
            spin=np.array([1.0 if f.name().endswith("_ccw") else -1.0 for f in frames]),
        )

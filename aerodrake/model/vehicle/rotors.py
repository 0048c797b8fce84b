"""Where the rotors of a robot are, as its URDF has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from aerodrake.support.errors import BadInput

ROTOR_PREFIX = "rotor_"
"""Of the names of the frames in the URDF that are rotors."""


@dataclass(frozen=True)
class Rotors:
    """Where the rotors are.

    Attributes:
        names: Of their frames, in the order of thrust vectors.
        p_B: (k, 3) m, their positions in the base frame.
        spin: (k,) +1 where the propeller turns counter-clockwise seen from above.
    """

    names: tuple[str, ...]
    p_B: np.ndarray
    spin: np.ndarray

    def mixer(self, torque_ratio: float) -> np.ndarray:
        """(4, k) from thrusts [N] to [collective thrust N, torque about the base x, y, z N m].

        Args:
            torque_ratio: m, drag torque over thrust; it acts against the spin.
        """
        x, y, _ = self.p_B.T
        return np.vstack([np.ones_like(x), y, -x, -self.spin * torque_ratio])

    @classmethod
    def of(cls, plant: MultibodyPlant, base: RigidBody, robot: str) -> Rotors:
        """Those of a robot.

        Args:
            plant: With the robot.
            base: The link that they are on.
            robot: Its file, for messages.

        Raises:
            BadInput: if there are less than four, or they are on another link, or tilted, or
                their frames' names do not tell which way they turn.
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

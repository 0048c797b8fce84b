"""Motion of base, joints and tool in one mode."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import eig

from aerodrake.analysis.coordinates import PLANT, RATE
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.linear_loop import AXES, TOOL
from aerodrake.analysis.sampled_system import SampledSystem


@dataclass(frozen=True)
class ModeShape:
    """Complex amplitudes of a mode: each motion is Re(amplitude exp(j phase)).

    Attributes:
        lengths: m, of the base (`x`, `y`, `z`) and of the tool (`tool_x`, ...).
        angles: rad, of the base (`roll`, `pitch`, `yaw`) and of the joints, by name.
    """

    lengths: dict[str, complex]
    angles: dict[str, complex]

    @classmethod
    def of(cls, system: SampledSystem, mode: Eigenmode) -> Self:
        """Returns the shape of a mode, with a tool that moves by 1 m, real where it moves most.

        Motions are 0 if the mode does not move the tool.
        """
        vector = eigenvector(system, mode.eigenvalue)
        outputs = dict(zip(system.outputs, system.C @ vector, strict=True))
        tool = {name: value for name, value in outputs.items() if name in TOOL}
        largest = max(tool.values(), key=abs, default=0.0)
        scale = np.linalg.norm(list(tool.values())) * np.exp(1j * np.angle(largest))
        factor = 1.0 / scale if abs(scale) > 1e-12 * np.linalg.norm(vector) else 0.0
        motions = {
            state.removeprefix(PLANT): complex(factor * value)
            for state, value in zip(system.states, vector, strict=True)
            if state.startswith(PLANT) and not state.endswith(RATE)
        }
        lengths = {name: motions.pop(name) for name in AXES if name in motions}
        lengths |= {name: complex(factor * value) for name, value in tool.items()}
        return cls(lengths, motions)


def eigenvector(system: SampledSystem, eigenvalue: complex) -> np.ndarray:
    """Returns the right eigenvector (nx,) of A for the eigenvalue next to a given one.

    Each state is in its own unit; the norm after division by `state_scale` is 1.
    """
    scaled = system.A / system.state_scale[:, None] * system.state_scale
    values, vectors = eig(scaled)
    return vectors[:, np.abs(values - eigenvalue).argmin()] * system.state_scale

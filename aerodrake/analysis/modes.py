"""Modes of a sampled system."""

from collections import defaultdict

import numpy as np
from scipy.linalg import eig

from aerodrake.analysis.eigenmode import Eigenmode, Participant
from aerodrake.analysis.sampled_system import SampledSystem

NEUTRAL_1_S = 0.02
"""1/s, growth up to which a mode is stable. An angle of the arm that neither the tool's position
nor a cost of the MPC depends on has a mode with neither growth nor decay, as an integrator."""

FORGOTTEN = 0.05
"""|z| below which a mode is omitted: most of it is gone after one period."""

LEAST_SHARE = 0.01
"""Smallest share of a participant."""


def find_modes(system: SampledSystem, change_1_s: float = 0.0) -> tuple[Eigenmode, ...]:
    """Returns the modes of a system, the fastest growing first.

    One of each pair of complex conjugate eigenvalues is returned, and none with |z| below
    `FORGOTTEN`. A growing mode is unstable if it is neither slower than `NEUTRAL_1_S` nor than
    the system itself changes.

    Args:
        system: The system.
        change_1_s: 1/s, rate at which its matrices change along a trajectory.
    """
    scale = system.state_scale
    values, left, right = eig(system.A / scale[:, None] * scale, left=True, right=True)
    names = [_participant(state) for state in system.states]
    order = np.argsort(-np.abs(values), kind="stable")
    return tuple(
        _mode(values[i], np.abs(left[:, i] * right[:, i]), names, system.dt, change_1_s)
        for i in order
        if values[i].imag >= 0 and abs(values[i]) >= FORGOTTEN
    )


def _mode(
    z: complex, factors: np.ndarray, names: list[str], dt: float, change_1_s: float
) -> Eigenmode:
    shares: dict[str, float] = defaultdict(float)
    for name, factor in zip(names, factors / factors.sum(), strict=True):
        shares[name] += float(factor)
    ranked = sorted(shares.items(), key=lambda item: -item[1])
    exponent = np.log(complex(z)) / dt
    return Eigenmode(
        eigenvalue=complex(z),
        growth_1_s=float(exponent.real),
        frequency_hz=float(abs(exponent.imag) / (2 * np.pi)),
        damping=float(-exponent.real / abs(exponent)) if exponent else 0.0,
        participants=tuple(Participant(*item) for item in ranked if item[1] >= LEAST_SHARE),
        is_stable=bool(exponent.real <= NEUTRAL_1_S or abs(exponent) <= change_1_s),
    )


def _participant(state: str) -> str:
    """Returns the body motion of a state of the plant, or the system of another one."""
    system, _, rest = state.partition(".")
    return rest.removesuffix("_rate") if system == "plant" else system.partition("[")[0]

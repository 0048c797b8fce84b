"""Modes of a linear loop."""

from collections import defaultdict

import numpy as np
from scipy.linalg import eig

from aerodrake.analysis.coordinates import PLANT, RATE
from aerodrake.analysis.eigenmode import Eigenmode, Participant
from aerodrake.analysis.linear_loop import LinearLoop, PeriodMatrices

NEUTRAL_1_S = 0.02
"""1/s, growth up to which a mode is stable. An angle of the arm that neither the tool's position
nor a cost of the MPC depends on has a mode with neither growth nor decay, as an integrator."""

FORGOTTEN = 0.05
"""|z| below which a mode is omitted: most of it is gone after one period."""

RESOLVED = 0.5
"""|z| below which the alias of an oscillation is not resolved, since it decays too fast."""

LEAST_PLANT = 0.3
"""Share of the plant below which it is not resolved, since the plant only follows others."""

LEAST_MOTION = 0.01
"""Motion in one period, relative to the displacement, below which a mode does not oscillate."""

CHANGES_PER_VELOCITY = 2.0
"""1/m and 1/rad, rate of change of the matrices along a path, over the largest velocity."""

LEAST_SHARE = 0.01
"""Smallest share of a participant."""


def find_modes(loop: LinearLoop) -> tuple[Eigenmode, ...]:
    """Returns the modes of a loop, the fastest growing first.

    One of each pair of complex conjugate eigenvalues is returned, and none with |z| below
    `FORGOTTEN`. A growing mode is unstable if it is neither slower than `NEUTRAL_1_S` nor than
    the loop itself changes.
    """
    period, scale = loop.nominal, loop.system.state_scale
    values, left, right = eig(period.A / scale[:, None] * scale, left=True, right=True)
    names = [_participant(state) for state in period.names]
    chosen = [
        i
        for i in np.argsort(-np.abs(values), kind="stable")
        if values[i].imag >= 0 and abs(values[i]) >= FORGOTTEN
    ]
    modes = []
    for i in chosen:
        exponent = exponent_of(values[i], left[:, i] / scale, right[:, i] * scale, period)
        exponent /= loop.period.dt
        modes.append(
            Eigenmode(
                eigenvalue=complex(values[i]),
                growth_1_s=exponent.real,
                frequency_hz=exponent.imag / (2 * np.pi),
                damping=-exponent.real / abs(exponent) if exponent else 0.0,
                participants=_participants(names, np.abs(left[:, i] * right[:, i])),
                is_stable=bool(are_stable(exponent, loop.period.fastest)),
            )
        )
    return tuple(modes)


def are_stable(exponents: np.ndarray | complex, fastest: float) -> np.ndarray:
    """Returns True for each mode that does not grow, or not faster than the loop itself changes.

    Args:
        exponents: (N,) 1/s, logarithms of eigenvalues per second.
        fastest: Largest velocity of base and joints, in m/s and rad/s.
    """
    is_slow = np.abs(exponents) <= CHANGES_PER_VELOCITY * fastest
    return (np.real(exponents) <= NEUTRAL_1_S) | is_slow


def exponent_of(z: complex, left: np.ndarray, right: np.ndarray, period: PeriodMatrices) -> complex:
    """Returns the logarithm of an eigenvalue of A, with imaginary part >= 0.

    The branch is the one whose imaginary part is the sum of the phases by which the largest rate
    of the plant advances from step to step of the period. This resolves the alias of a fast
    oscillation.

    Args:
        z: The eigenvalue.
        left, right: (nx,) eigenvectors.
        period: Matrices of the period.
    """
    exponent = np.log(complex(z))
    factors = np.abs(left * right)
    is_plant = [name.startswith(PLANT) for name in period.names]
    if abs(z) < RESOLVED or factors[is_plant].sum() < LEAST_PLANT * factors.sum():
        return complex(exponent.real, abs(exponent.imag))
    positions, rates = np.split(np.abs(motion := period.plant @ right), 2, axis=1)
    i = rates.max(axis=0).argmax()
    if rates.max() * period.dt < LEAST_MOTION * positions.max():
        return complex(exponent.real, abs(exponent.imag))
    fastest = motion[:, len(rates[0]) + i]
    phases = np.angle(fastest[1:] * fastest[:-1].conj())
    phases[phases < 1e-6 - np.pi] += 2 * np.pi  # A real motion that changes its sign.
    turns = round((phases.sum() - exponent.imag) / (2 * np.pi))
    return complex(exponent.real, abs(exponent.imag + 2 * np.pi * turns))


def _participants(names: list[str], factors: np.ndarray) -> tuple[Participant, ...]:
    shares: dict[str, float] = defaultdict(float)
    for name, factor in zip(names, factors / factors.sum(), strict=True):
        shares[name] += float(factor)
    ranked = sorted(shares.items(), key=lambda item: -item[1])
    return tuple(Participant(*item) for item in ranked if item[1] >= LEAST_SHARE)


def _participant(state: str) -> str:
    """Returns the body motion of a state of the plant, or the system of another one."""
    if state.startswith(PLANT):
        return state.removeprefix(PLANT).removesuffix(RATE)
    return state.partition(".")[0].partition("[")[0]

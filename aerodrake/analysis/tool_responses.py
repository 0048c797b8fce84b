"""Step and frequency responses of the tool, from a sampled system."""

import numpy as np
from scipy.linalg import schur, solve_triangular

from aerodrake.analysis.linear_loop import FORCES, TOOL, TORQUES
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.analysis.sampled_system import SampledSystem

STEP_S = 5.0
"""s, duration of a step response."""

SETTLED = 0.02
"""Distance from the final position, relative to the peak, within which the tool has settled."""

LOWEST_HZ, FREQUENCIES = 0.05, 200
"""Lowest frequency of a frequency response, and number of frequencies."""

UNITS = {
    "force": "m/N",
    "torque": "m/(N m)",
    "position_noise": "m/m",
    "velocity_noise": "m/(m/s)",
    "attitude_noise": "m/rad",
    "rate_noise": "m/(rad/s)",
    "joint_noise": "m/rad",
}
"""Groups of inputs, and units of the gain from each to the tool's position."""


def step_responses(system: SampledSystem) -> tuple[StepResponse, ...]:
    """Returns the tool's motion after a step of force and of torque along each axis."""
    path = system.between((*FORCES, *TORQUES), TOOL)
    steps = round(STEP_S / path.dt)
    x, motions = np.zeros(path.B.shape), np.empty((steps + 1, *path.D.shape))
    with np.errstate(over="ignore", invalid="ignore"):  # An unstable response is not finite.
        for k in range(steps + 1):  # Importing scipy.signal takes half a second.
            motions[k] = path.C @ x + path.D
            x = path.A @ x + path.B
        time_s = path.dt * np.arange(steps + 1)
        return tuple(
            _step_response(name, time_s, motions[:, :, i]) for i, name in enumerate(path.inputs)
        )


def _step_response(name: str, time_s: np.ndarray, values: np.ndarray) -> StepResponse:
    """Returns the response of one input, with its peak and settling time."""
    peak = float(np.linalg.norm(values, axis=1).max())
    away = np.flatnonzero(np.linalg.norm(values - values[-1], axis=1) > SETTLED * peak)
    # A response that is away near the end has no final position yet.
    first = int(away[-1]) + 1 if len(away) else 0
    is_settled = np.isfinite(peak) and first <= 0.9 * (len(time_s) - 1)
    unit = UNITS[name.rpartition("_")[0]]
    settling_s = float(time_s[first]) if is_settled else None
    return StepResponse(name, unit, time_s, values, peak, settling_s)


def frequency_responses(system: SampledSystem) -> tuple[FrequencyResponse, ...]:
    """Returns the gains from disturbances and sensor noise to the tool over frequency."""
    hz = np.geomspace(LOWEST_HZ, 0.5 / system.dt, FREQUENCIES)
    path = system.between(system.inputs, TOOL)
    # A = Q T Q^H, so that each frequency takes one triangular system.
    T, Q = schur(path.A / system.state_scale[:, None] * system.state_scale, output="complex")
    B = Q.conj().T @ (path.B / system.state_scale[:, None])
    C = (path.C * system.state_scale) @ Q
    identity = np.eye(len(T))
    gains = [
        C @ solve_triangular(z * identity - T, B) + path.D
        for z in np.exp(2j * np.pi * hz * system.dt)
    ]
    responses = []
    for group, unit in UNITS.items():
        columns = [i for i, name in enumerate(path.inputs) if name.startswith(f"{group}_")]
        magnitude = np.array([np.linalg.norm(gain[:, columns], 2) for gain in gains])
        k = int(np.argmax(magnitude))
        responses.append(
            FrequencyResponse(group, unit, hz, magnitude, float(magnitude[k]), float(hz[k]))
        )
    return tuple(responses)

"""Made-up analyses of small systems whose modes are known."""

import numpy as np
from scipy.linalg import block_diag, expm

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.eigenmode import Eigenmode, Participant
from aerodrake.analysis.margins import StabilityLimit, StabilityMargin
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.analysis.sampled_system import SampledSystem

DT = 0.02

MARGINS = (
    StabilityMargin("base_delay", "delay", 0.0, (0.0, 0.2), None, StabilityLimit(0.022, 5.13)),
    StabilityMargin("rotor_gain", "gain", 1.0, (0.1, 5.0), StabilityLimit(0.31, 0.9), None),
    StabilityMargin("joint_gain", "gain", 1.0, (0.1, 5.0), None, StabilityLimit(2.4, 14.2)),
)


def oscillator(growth_1_s: float, frequency_hz: float) -> np.ndarray:
    """(2, 2) of a motion and its rate, sampled every `DT`."""
    omega = 2 * np.pi * frequency_hz
    return expm(DT * np.array([[0, 1], [-(growth_1_s**2 + omega**2), 2 * growth_1_s]]))


def mode(growth_1_s: float, frequency_hz: float, *participants: tuple[str, float]) -> Eigenmode:
    """The mode of `oscillator`, or of a decay if the frequency is 0."""
    pole = complex(growth_1_s, 2 * np.pi * frequency_hz)
    named = tuple(Participant(*participant) for participant in participants)
    damping = -growth_1_s / abs(pole)
    return Eigenmode(np.exp(DT * pole), growth_1_s, frequency_hz, damping, named, growth_1_s < 0)


def point(growth_1_s: float, time_s: float | None = None) -> OperatingPoint:
    """The loop with a roll that grows at 9.6 Hz, a slow x, an observer, and a stiff joint."""
    A = block_diag(
        oscillator(growth_1_s, 9.6), oscillator(-3.0, 0.4), np.exp(-10.0 * DT), np.exp(-200.0 * DT)
    )
    states = (
        "plant.roll",
        "plant.roll_rate",
        "plant.x",
        "plant.x_rate",
        "controller.h",
        "plant.joint_2",
    )
    B, C = np.zeros((6, 1)), np.zeros((3, 6))
    B[3], C[0, 2], C[1, 0] = DT, 1.0, 0.3
    inputs, outputs = ("force_x",), ("tool_x", "tool_y", "tool_z")
    system = SampledSystem(A, B, C, np.zeros((3, 1)), DT, states, inputs, outputs, np.ones(6))
    modes = (
        mode(growth_1_s, 9.6, ("roll", 0.7), ("joint_2", 0.3)),
        mode(-3.0, 0.4, ("x", 1.0)),
        mode(-10.0, 0.0, ("controller", 1.0)),
        mode(-200.0, 0.0, ("joint_2", 1.0)),
    )
    return OperatingPoint(time_s, system, modes)


def made(growth_1_s: float = -2.0, times: tuple[float, ...] = ()) -> Analysis:
    """An analysis whose fastest mode has the growth in hover, and is unstable after 3 s."""
    time_s = np.linspace(0.0, 2.0, 101)
    values = np.outer(1e-3 * (1 - np.exp(-3 * time_s)), [1.0, 0.0, 0.0])
    hz = np.geomspace(0.05, 25.0, 60)
    return Analysis(
        "made",
        point(growth_1_s),
        MARGINS,
        tuple(StepResponse(f"force_{axis}", "m/N", time_s, values, 1e-3, 1.3) for axis in "xyz"),
        tuple(
            FrequencyResponse(name, unit, hz, scale / (1 + hz**2), scale, 0.05)
            for name, unit, scale in (
                ("force", "m/N", 1e-3),
                ("torque", "m/(N m)", 3e-3),
                ("position_noise", "m/m", 1.0),
                ("joint_noise", "m/rad", 0.4),
            )
        ),
        tuple(point(-2.0 if time <= 3 else 1.5, time) for time in times),
        "",
    )

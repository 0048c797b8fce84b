"""Results of an analysis of the closed loop."""

from dataclasses import dataclass

from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.margins import StabilityMargin
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.analysis.sampled_system import SampledSystem


@dataclass(frozen=True)
class OperatingPoint:
    """The closed loop linearised at one instant.

    Attributes:
        time_s: s, reference time; None in hover.
        system: The linear system over one MPC period.
        modes: All modes, the fastest growing first.
    """

    time_s: float | None
    system: SampledSystem
    modes: tuple[Eigenmode, ...]

    @property
    def is_stable(self) -> bool:
        """True if all modes are stable."""
        return all(mode.is_stable for mode in self.modes)

    @property
    def sentence(self) -> str:
        """One line, such as `unstable in hover: roll and joint_2 at 9.6 Hz grow by 5.0 1/s`.

        Of a stable loop it is about the least damped mode.
        """
        where = "in hover" if self.time_s is None else f"at {self.time_s:.2f} s"
        verdict = f"{'stable' if self.is_stable else 'unstable'} {where}"
        if not self.modes:
            return verdict
        mode = min(self.modes, key=lambda mode: (mode.is_stable, mode.damping))
        names = [participant.name for participant in mode.participants[:2]] or ["a mode"]
        verb = "decay" if mode.is_stable else "grow"
        motion = f"{' and '.join(names)} at {mode.frequency_hz:.1f} Hz {verb}"
        s = "s" * (len(names) == 1)
        return f"{verdict}: {motion}{s} by {abs(mode.growth_1_s):.1f} 1/s"


@dataclass(frozen=True)
class Analysis:
    """Stability, margins and responses of a scenario's closed loop.

    Attributes:
        scenario: Its name.
        hover: The loop in hover.
        margins: Delay and gain margins in hover.
        step_responses: In hover, of force and torque along each axis.
        frequency_responses: In hover, of force, torque, and the noise of each sensor.
        path: The loop at the requested times, in order, up to the end of the flight.
        ended: Empty, or the reason why the flight ended before the last requested time.
    """

    scenario: str
    hover: OperatingPoint
    margins: tuple[StabilityMargin, ...]
    step_responses: tuple[StepResponse, ...]
    frequency_responses: tuple[FrequencyResponse, ...]
    path: tuple[OperatingPoint, ...]
    ended: str

    @property
    def is_stable(self) -> bool:
        """True if the loop is stable in hover and at all points of the path."""
        return all(point.is_stable for point in (self.hover, *self.path))

    @property
    def sentence(self) -> str:
        """The sentence of the first unstable operating point, else that of hover."""
        points = (self.hover, *self.path)
        return next((point for point in points if not point.is_stable), self.hover).sentence

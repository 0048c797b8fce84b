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
        """One line, such as `unstable in hover: roll and joint_2 at 9.6 Hz grow by 5.0 1/s`, or
        `stable in hover: the slowest oscillation ...`."""
        raise NotImplementedError


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

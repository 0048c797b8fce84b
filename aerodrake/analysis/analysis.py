"""Results of an analysis of the closed loop."""

from dataclasses import dataclass

from aerodrake.analysis.coordinates import PLANT
from aerodrake.analysis.eigenmode import Eigenmode, Participant
from aerodrake.analysis.margins import StabilityMargin
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.analysis.sampled_system import SampledSystem


@dataclass(frozen=True)
class OperatingPoint:
    """The closed loop linearised at one instant.

    Attributes:
        time_s: s, reference time; None in hover.
        system: The linear system over one period, in general that of the MPC.
        modes: All modes, the fastest growing first.
        saturated: Names of joints and rotors whose command is at its limit, where the loop is open.
        is_settled: False for a hover that neither comes to rest nor begins in equilibrium. It is
            linearised in motion, soon after trim.
    """

    time_s: float | None
    system: SampledSystem
    modes: tuple[Eigenmode, ...]
    saturated: tuple[str, ...] = ()
    is_settled: bool = True

    @property
    def is_stable(self) -> bool:
        """True if all modes are stable."""
        return all(mode.is_stable for mode in self.modes)

    @property
    def least_damped(self) -> tuple[Eigenmode, ...]:
        """The unstable modes, the fastest growing first, and the others by damping ratio.

        Modes that decay by more than half in a period are left out.
        """
        slow = (mode for mode in self.modes if abs(mode.eigenvalue) > 0.5)
        return tuple(sorted(slow, key=_damping))

    def motions(self, mode: Eigenmode) -> list[Participant]:
        """Returns the motions of the plant that take part in a mode, the largest share first."""
        return [p for p in mode.participants if f"{PLANT}{p.name}" in self.system.states]

    @property
    def sentence(self) -> str:
        """Verdict in one line, with motions, frequency and growth of one mode.

        The mode is the fastest growing one, or the least damped one of a stable loop.
        """
        where = "in hover" if self.time_s is None else f"at {self.time_s:.2f} s"
        verdict = f"{'stable' if self.is_stable else 'unstable'} {where}"
        if not self.least_damped:
            return verdict
        mode = self.least_damped[0]
        motions = self.motions(mode)
        largest = [*motions, *(p for p in mode.participants if p not in motions)][:2]
        names = [p.name for p in largest if p.share > largest[0].share / 2] or ["a mode"]
        verb = ("decay" if mode.is_stable else "grow") + "s" * (len(names) == 1)
        rate = f"{verb} by {abs(mode.growth_1_s):.1f} 1/s"
        return f"{verdict}: {' and '.join(names)} at {mode.frequency_hz:.1f} Hz {rate}"


def _damping(mode: Eigenmode) -> tuple[bool, float]:
    """Returns a key for sorting: by growth, or by damping, which is undefined at z = 1."""
    if not mode.is_stable:
        return False, -mode.growth_1_s
    return True, mode.damping if mode.frequency_hz > 0 else 1.0


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

"""The faults that a scenario can inject: what breaks, when, and for how long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from aerodrake.scenario.schema import choice, quantity

SAMPLE_GROUPS = ("position", "attitude", "joints")
"""Of a sample's numbers: p_B and v_B; quaternion and omega_W; q and q'."""


@dataclass(frozen=True)
class Fault:
    """When it begins, and how long it lasts. What it says of itself comes with its kind."""

    # Reference time.
    start_s: float = quantity(5.0, "s", -60.0, 3600.0)
    duration_s: float = quantity(1.0, "s", 0.0, 3600.0)

    @property
    def end_s(self) -> float:
        """s, reference time at which it is over."""
        return round(self.start_s + self.duration_s, 9)

    def is_active(self, time: Any) -> Any:
        """Whether it is, at a reference time or at each of several, s."""
        return (self.start_s <= time) & (time < self.end_s)


@dataclass(frozen=True)
class SampleFault(Fault):
    """Of all of the samples' numbers, or of one of `SAMPLE_GROUPS`."""

    group: str = choice("all", *SAMPLE_GROUPS)


@dataclass(frozen=True)
class SampleNan(SampleFault):
    """Samples that are no numbers."""

    kind: ClassVar[str] = "sample_nan"


@dataclass(frozen=True)
class SampleStale(SampleFault):
    """No samples come: the last ones stay, with their times."""

    kind: ClassVar[str] = "sample_stale"


@dataclass(frozen=True)
class SampleFrozen(SampleFault):
    """Samples go on coming, and always say the same."""

    kind: ClassVar[str] = "sample_frozen"


@dataclass(frozen=True)
class SampleJump(SampleFault):
    """Samples are off by a step: p_B along (1, 1, 1), attitude about it, each joint's angle."""

    kind: ClassVar[str] = "sample_jump"
    position_m: float = quantity(0.5, "m", -100.0, 100.0)
    angle_rad: float = quantity(0.5, "rad", -3.1416, 3.1416)


@dataclass(frozen=True)
class RotorDegraded(Fault):
    """A rotor gives a share of its thrust; of 0 it is lost."""

    kind: ClassVar[str] = "rotor_degraded"
    # In the order of the robot's frames `rotor_*`, from 0.
    rotor: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.8, "1", 0.0, 1.0)


@dataclass(frozen=True)
class JointDegraded(Fault):
    """A joint's motor gives a share of its torque."""

    kind: ClassVar[str] = "joint_degraded"
    # In the robot's order, from 0.
    joint: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.5, "1", 0.0, 1.0)


@dataclass(frozen=True)
class Push(Fault):
    """A force on the base, at its origin."""

    kind: ClassVar[str] = "push"
    force_n: tuple[float, ...] = quantity((5.0, 0.0, 0.0), "N", -200.0, 200.0, length=3)


@dataclass(frozen=True)
class MpcInfeasible(Fault):
    """Programs get bounds that contradict each other."""

    kind: ClassVar[str] = "mpc_infeasible"


@dataclass(frozen=True)
class MpcStarved(Fault):
    """The solver has OSQP alone, and that for a few iterations."""

    kind: ClassVar[str] = "mpc_starved"
    iterations: int = quantity(1, "iterations", 1, 1000)


@dataclass(frozen=True)
class MpcNonFinite(Fault):
    """Programs get costs that are no numbers."""

    kind: ClassVar[str] = "mpc_non_finite"


@dataclass(frozen=True)
class MpcMissed(Fault):
    """Ticks do not happen."""

    kind: ClassVar[str] = "mpc_missed"


@dataclass(frozen=True)
class LearnerFault(Fault):
    """Of the residual's online learning; nothing where there is no network."""


@dataclass(frozen=True)
class LearnerNan(LearnerFault):
    """The last layer loses its numbers."""

    kind: ClassVar[str] = "learner_nan"


@dataclass(frozen=True)
class LearnerDiverged(LearnerFault):
    """At each update all numbers of the last layer are off by as much."""

    kind: ClassVar[str] = "learner_diverged"
    theta_m_s: float = quantity(1.0, "m/s", -1e6, 1e6)


@dataclass(frozen=True)
class LearnerPoisoned(LearnerFault):
    """Measured velocities are off where the learner learns from them, and nowhere else."""

    kind: ClassVar[str] = "learner_poisoned"
    velocity_m_s: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceJump(Fault):
    """The end-effector's reference is elsewhere."""

    kind: ClassVar[str] = "reference_jump"
    offset_m: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m", -1000.0, 1000.0, length=3)


@dataclass(frozen=True)
class ReferenceDrift(Fault):
    """The end-effector's reference moves on by itself, and is back at the end."""

    kind: ClassVar[str] = "reference_drift"
    velocity_m_s: tuple[float, ...] = quantity((3.0, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceNan(Fault):
    """The end-effector's reference is no number."""

    kind: ClassVar[str] = "reference_nan"


AnyFault = (
    SampleNan
    | SampleStale
    | SampleFrozen
    | SampleJump
    | RotorDegraded
    | JointDegraded
    | Push
    | MpcInfeasible
    | MpcStarved
    | MpcNonFinite
    | MpcMissed
    | LearnerNan
    | LearnerDiverged
    | LearnerPoisoned
    | ReferenceJump
    | ReferenceDrift
    | ReferenceNan
)

MPC_FAULTS = (MpcInfeasible, MpcStarved, MpcNonFinite, MpcMissed)
REFERENCE_FAULTS = (ReferenceJump, ReferenceDrift, ReferenceNan)

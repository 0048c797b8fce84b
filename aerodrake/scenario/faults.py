"""Faults that a scenario can inject, each with its start and its duration."""

from dataclasses import dataclass
from typing import Any, ClassVar

from aerodrake.scenario.schema import choice, quantity

SAMPLE_GROUPS = ("position", "attitude", "joints")
"""Groups of a sample's values: p_B and v_B; quaternion and omega_W; q and q'."""


@dataclass(frozen=True)
class Fault:
    """Start and duration of a fault."""

    # In reference time.
    start_s: float = quantity(5.0, "s", -60.0, 3600.0)
    duration_s: float = quantity(1.0, "s", 0.0, 3600.0)

    @property
    def end_s(self) -> float:
        """Reference time in s at which the fault ends."""
        return round(self.start_s + self.duration_s, 9)

    def is_active(self, time: Any) -> Any:
        """Returns True if the fault is active at a reference time in s; also for arrays."""
        return (self.start_s <= time) & (time < self.end_s)


@dataclass(frozen=True)
class SampleFault(Fault):
    """Fault of the samples: of all values, or of one of `SAMPLE_GROUPS`."""

    group: str = choice("all", *SAMPLE_GROUPS)


@dataclass(frozen=True)
class SampleNan(SampleFault):
    """Samples are NaN."""

    kind: ClassVar[str] = "sample_nan"


@dataclass(frozen=True)
class SampleStale(SampleFault):
    """No samples arrive: the last ones are repeated with their time stamps."""

    kind: ClassVar[str] = "sample_stale"


@dataclass(frozen=True)
class SampleFrozen(SampleFault):
    """Samples arrive with new time stamps and constant values."""

    kind: ClassVar[str] = "sample_frozen"


@dataclass(frozen=True)
class SampleJump(SampleFault):
    """Samples have an offset: p_B along (1, 1, 1), the attitude about it, each joint's angle."""

    kind: ClassVar[str] = "sample_jump"
    position_m: float = quantity(0.5, "m", -100.0, 100.0)
    angle_rad: float = quantity(0.5, "rad", -3.1416, 3.1416)


@dataclass(frozen=True)
class RotorDegraded(Fault):
    """A rotor gives a fraction of its commanded thrust."""

    kind: ClassVar[str] = "rotor_degraded"
    # Index from 0, in the order of the robot's frames `rotor_*`.
    rotor: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.8, "1", 0.0, 1.0)


@dataclass(frozen=True)
class JointDegraded(Fault):
    """A joint's motor gives a fraction of its commanded torque."""

    kind: ClassVar[str] = "joint_degraded"
    # Index from 0, in the robot's order.
    joint: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.5, "1", 0.0, 1.0)


@dataclass(frozen=True)
class Push(Fault):
    """A force on the base at its origin."""

    # In the world frame.
    kind: ClassVar[str] = "push"
    force_n: tuple[float, ...] = quantity((5.0, 0.0, 0.0), "N", -200.0, 200.0, length=3)


@dataclass(frozen=True)
class MpcInfeasible(Fault):
    """The MPC's programs have contradicting bounds."""

    kind: ClassVar[str] = "mpc_infeasible"


@dataclass(frozen=True)
class MpcStarved(Fault):
    """The MPC's programs are solved by OSQP alone, with a few iterations."""

    kind: ClassVar[str] = "mpc_starved"
    iterations: int = quantity(1, "iterations", 1, 1000)


@dataclass(frozen=True)
class MpcNonFinite(Fault):
    """The MPC's programs have a cost that is NaN."""

    kind: ClassVar[str] = "mpc_non_finite"


@dataclass(frozen=True)
class MpcMissed(Fault):
    """The MPC's ticks are skipped."""

    kind: ClassVar[str] = "mpc_missed"


@dataclass(frozen=True)
class LearnerFault(Fault):
    """Fault of the residual's online learning, without effect if residual.mode is off."""


@dataclass(frozen=True)
class LearnerNan(LearnerFault):
    """The weights of the last layer are NaN."""

    kind: ClassVar[str] = "learner_nan"


@dataclass(frozen=True)
class LearnerDiverged(LearnerFault):
    """Each update adds an offset to all weights of the last layer."""

    kind: ClassVar[str] = "learner_diverged"
    theta_m_s: float = quantity(1.0, "m/s", -1e6, 1e6)


@dataclass(frozen=True)
class LearnerPoisoned(LearnerFault):
    """Velocities in the learner's labels have an offset; other uses of them do not."""

    kind: ClassVar[str] = "learner_poisoned"
    velocity_m_s: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceJump(Fault):
    """The end-effector's reference has an offset."""

    kind: ClassVar[str] = "reference_jump"
    offset_m: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m", -1000.0, 1000.0, length=3)


@dataclass(frozen=True)
class ReferenceDrift(Fault):
    """The end-effector's reference drifts at a constant velocity until the fault ends."""

    kind: ClassVar[str] = "reference_drift"
    velocity_m_s: tuple[float, ...] = quantity((3.0, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceNan(Fault):
    """The end-effector's reference is NaN."""

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

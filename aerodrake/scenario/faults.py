"""Faults that a scenario can inject, each with its start and its duration."""

from dataclasses import dataclass
from typing import Any

from aerodrake.scenario.schema import Kind, choice, quantity

SAMPLE_GROUPS = ("position", "attitude", "joints")
"""Groups of a sample's values: p_B and v_B; quaternion and omega_W; q and q'."""


@dataclass(frozen=True)
class Fault(Kind):
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
class SampleNan(SampleFault, kind="sample_nan"):
    """Samples are NaN."""


@dataclass(frozen=True)
class SampleStale(SampleFault, kind="sample_stale"):
    """No samples arrive: the last ones are repeated with their time stamps."""


@dataclass(frozen=True)
class SampleFrozen(SampleFault, kind="sample_frozen"):
    """Samples arrive with new time stamps and constant values."""


@dataclass(frozen=True)
class SampleJump(SampleFault, kind="sample_jump"):
    """Samples have an offset: p_B along (1, 1, 1), the attitude about it, each joint's angle."""

    position_m: float = quantity(0.5, "m", -100.0, 100.0)
    angle_rad: float = quantity(0.5, "rad", -3.1416, 3.1416)


@dataclass(frozen=True)
class RotorDegraded(Fault, kind="rotor_degraded"):
    """A rotor gives a fraction of its commanded thrust."""

    # Index from 0, in the order of the robot's frames `rotor_*`.
    rotor: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.8, "1", 0.0, 1.0)


@dataclass(frozen=True)
class JointDegraded(Fault, kind="joint_degraded"):
    """A joint's motor gives a fraction of its commanded torque."""

    # Index from 0, in the robot's order.
    joint: int = quantity(0, "1", 0, 15)
    remaining: float = quantity(0.5, "1", 0.0, 1.0)


@dataclass(frozen=True)
class Push(Fault, kind="push"):
    """A force on the base at its origin."""

    # In the world frame.
    force_n: tuple[float, ...] = quantity((5.0, 0.0, 0.0), "N", -200.0, 200.0, length=3)


@dataclass(frozen=True)
class MpcInfeasible(Fault, kind="mpc_infeasible"):
    """The MPC's programs have contradicting bounds."""


@dataclass(frozen=True)
class MpcStarved(Fault, kind="mpc_starved"):
    """The MPC's programs are solved with a few iterations, without shortcut or refinement."""

    iterations: int = quantity(1, "iterations", 1, 1000)


@dataclass(frozen=True)
class MpcNonFinite(Fault, kind="mpc_non_finite"):
    """The MPC's programs have a cost that is NaN."""


@dataclass(frozen=True)
class MpcMissed(Fault, kind="mpc_missed"):
    """The MPC's ticks are skipped."""


@dataclass(frozen=True)
class LearnerNan(Fault, kind="learner_nan"):
    """The weights of the last layer are NaN."""


@dataclass(frozen=True)
class LearnerDiverged(Fault, kind="learner_diverged"):
    """Each update adds an offset to all weights of the last layer."""

    theta_m_s: float = quantity(1.0, "m/s", -1e6, 1e6)


@dataclass(frozen=True)
class LearnerPoisoned(Fault, kind="learner_poisoned"):
    """Velocities in the learner's labels have an offset; other uses of them do not."""

    velocity_m_s: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceJump(Fault, kind="reference_jump"):
    """The end-effector's reference has an offset."""

    offset_m: tuple[float, ...] = quantity((0.3, 0.0, 0.0), "m", -1000.0, 1000.0, length=3)


@dataclass(frozen=True)
class ReferenceDrift(Fault, kind="reference_drift"):
    """The end-effector's reference drifts at a constant velocity until the fault ends."""

    velocity_m_s: tuple[float, ...] = quantity((3.0, 0.0, 0.0), "m/s", -100.0, 100.0, length=3)


@dataclass(frozen=True)
class ReferenceNan(Fault, kind="reference_nan"):
    """The end-effector's reference is NaN."""


AnySampleFault = SampleNan | SampleStale | SampleFrozen | SampleJump
PlantFault = RotorDegraded | JointDegraded | Push
MpcFault = MpcInfeasible | MpcStarved | MpcNonFinite | MpcMissed
LearnerFault = LearnerNan | LearnerDiverged | LearnerPoisoned
"""Faults of the residual's online learning, without effect if residual.mode is off."""
ReferenceFault = ReferenceJump | ReferenceDrift | ReferenceNan
AnyFault = AnySampleFault | PlantFault | MpcFault | LearnerFault | ReferenceFault

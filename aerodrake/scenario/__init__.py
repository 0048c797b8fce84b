"""Scenarios: the sections of one flight with units and ranges, and their YAML files.

The package exports every section, every kind of reference, orientation and fault, and their unions.
"""

from aerodrake.scenario.environment import (
    Mismatch,
    Payload,
    Sensors,
    Wind,
)
from aerodrake.scenario.faults import (
    MPC_FAULTS,
    REFERENCE_FAULTS,
    SAMPLE_GROUPS,
    AnyFault,
    Fault,
    JointDegraded,
    LearnerDiverged,
    LearnerFault,
    LearnerNan,
    LearnerPoisoned,
    MpcInfeasible,
    MpcMissed,
    MpcNonFinite,
    MpcStarved,
    Push,
    ReferenceDrift,
    ReferenceJump,
    ReferenceNan,
    RotorDegraded,
    SampleFault,
    SampleFrozen,
    SampleJump,
    SampleNan,
    SampleStale,
)
from aerodrake.scenario.references import (
    AxisAlong,
    Clover,
    FigureEight,
    FixedAxis,
    Hover,
    Lissajous,
    MovingTarget,
    Orientation,
    OrientationOff,
    Reference,
    Waypoints,
)
from aerodrake.scenario.sections import (
    Allocation,
    Arm,
    Clik,
    Filter,
    Flight,
    Model,
    Mpc,
    Rates,
    Residual,
    Scenario,
    Supervisor,
    Weights,
)
from aerodrake.scenario.vehicle import Rotor, Vehicle

__all__ = [
    "Allocation", "AnyFault", "Arm", "AxisAlong", "Clik", "Clover", "Fault",
    "FigureEight", "Filter", "FixedAxis", "Flight", "Hover", "JointDegraded", "LearnerDiverged",
    "LearnerFault", "LearnerNan", "LearnerPoisoned", "Lissajous", "MPC_FAULTS", "Mismatch", "Model",
    "MovingTarget", "Mpc", "MpcInfeasible", "MpcMissed", "MpcNonFinite", "MpcStarved",
    "Orientation", "OrientationOff", "Payload", "Push", "REFERENCE_FAULTS", "Rates", "Reference",
    "ReferenceDrift", "ReferenceJump", "ReferenceNan", "Residual", "Rotor", "RotorDegraded",
    "SAMPLE_GROUPS", "SampleFault", "SampleFrozen", "SampleJump", "SampleNan", "SampleStale",
    "Scenario", "Sensors", "Supervisor", "Vehicle", "Waypoints", "Weights", "Wind"
]  # fmt: skip

"""Scenarios: the sections of one flight with units and ranges, and their YAML files.

The package exports every section, every kind of reference, orientation and fault, and their unions.
"""

from aerodrake.scenario.actuation import Actuation
from aerodrake.scenario.environment import Air, Mismatch, Payload, Physics, Wind
from aerodrake.scenario.faults import (
    SAMPLE_GROUPS,
    AnyFault,
    Fault,
    JointDegraded,
    LearnerDiverged,
    LearnerFault,
    LearnerNan,
    LearnerPoisoned,
    MpcFault,
    MpcInfeasible,
    MpcMissed,
    MpcNonFinite,
    MpcStarved,
    Push,
    ReferenceDrift,
    ReferenceFault,
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
from aerodrake.scenario.residual import Guards, Residual
from aerodrake.scenario.scenario import Scenario
from aerodrake.scenario.sections import (
    Allocation,
    Arm,
    Clik,
    Filter,
    Flight,
    Model,
    Mpc,
    Rates,
    Rotor,
    Supervisor,
    Vehicle,
    Weights,
)
from aerodrake.scenario.sensors import (
    Accelerometer,
    AttitudeSensor,
    JointSensors,
    PositionSensor,
    Sampling,
    Sensors,
    ToolSensor,
)

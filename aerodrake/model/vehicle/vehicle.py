"""Model of the vehicle: facts from its URDF, and its trim."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.arm_inertia import reduced_inertia
from aerodrake.model.vehicle.joint_values import per_joint
from aerodrake.model.vehicle.overlap import deepest_overlap
from aerodrake.model.vehicle.robot import (
    BASE_FRAME,
    TOOL_AXIS,
    TOOL_FRAME,
    RobotDescription,
    arm_joints,
    make_nominal_plant,
)
from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES, VehicleState
from aerodrake.model.vehicle.tucking import GroundGeometry, tuck
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput, ScenarioError, file_at

GRAVITY = 9.81
"""m/s^2, Drake's default."""
ROUNDING_M = 1e-6
"""Depth to which feet that rest on the ground may be below it, and links may overlap."""
LIGHTEST, HEAVIEST = 1e-9, 1e9
"""Bounds of masses in kg and moments of inertia in kg m^2."""


@dataclass(frozen=True)
class VehicleModel:
    """Facts about the robot, all read from its URDF, and its trim.

    Its nominal plant is parsed once and shared by kinematics, dynamics and tucking, each with a
    Context of its own.

    Attributes:
        source: Source of the scenario, for messages.
        description: The robot's URDF.
        plant: Finalised plant of the robot alone, as in its URDF, with a free base.
        ground_geometry: Collision geometry of the robot.
        joint_names: Names of the n arm joints, from the base to the tool.
        lower, upper: (n,) rad, joint position limits.
        velocity: (n,) rad/s, joint velocity limits.
        acceleration: (n,) rad/s^2, joint acceleration limits.
        effort: (n,) N m, joint torque limits.
        rotors: Positions and spin of the rotors.
        p_B: (3,) m, initial position of the base.
        working: (n,) rad, the working configuration.
        p_O: (3,) m, position of the tool there, in the base frame: centre of the learning space.
        tool_axis: (3,) direction of the tool's axis there, in the base frame.
        mass: kg, base and arm.
        inertia: (3, 3) kg m^2, of base and arm in the working configuration,
            about their common centre of mass, in the base frame.
        arm_inertia: (n, n) kg m^2, inertia of the arm there, with a free base; see `ArmInertia`.
        joint_damping: (n,) N m s/rad, viscous damping of each joint.
        trim_wrench: (4,) [N, N m, N m, N m], wrench of the rotors in hover there.
        trim_torque: (n,) N m, joint torques in hover there.
    """

    source: str
    description: RobotDescription = field(repr=False)
    plant: MultibodyPlant = field(repr=False)
    ground_geometry: GroundGeometry = field(repr=False)
    joint_names: tuple[str, ...]
    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray
    rotors: Rotors
    p_B: np.ndarray
    working: np.ndarray
    p_O: np.ndarray
    tool_axis: np.ndarray
    mass: float
    inertia: np.ndarray
    arm_inertia: np.ndarray
    joint_damping: np.ndarray
    trim_wrench: np.ndarray
    trim_torque: np.ndarray

    @property
    def robot(self) -> str:
        """URI or path of the URDF."""
        return self.description.robot

    @property
    def feet_m(self) -> float:
        """Lowest point of the base in its frame, in m; the vehicle lands on it."""
        return self.ground_geometry.feet

    @property
    def joints(self) -> int:
        """Number n of arm joints."""
        return len(self.joint_names)

    @property
    def p_E(self) -> np.ndarray:
        """(3,) m, initial position of the end-effector."""
        return self.p_B + self.p_O

    @property
    def trim_state(self) -> np.ndarray:
        """(13 + 2 n,) initial `VehicleState` of flights: hover in the working configuration."""
        return VehicleState.at_rest(self.p_B, self.working).to_vector()

    @cached_property
    def tucked(self) -> np.ndarray:
        """(n,) rad, configuration of the arm for a landing; see `tuck`."""
        return tuck(self.ground_geometry, self.working)

    def per_joint(self, values: tuple[float, ...], key: str) -> np.ndarray:
        """Returns (n,) values from a scenario's list of one value, or one per joint.

        Raises:
            ScenarioError: if the list has another length.
        """
        return per_joint(values, self.joints, self.source, key)

    @classmethod
    @checked
    def load(cls, scenario: Scenario) -> Self:
        """Reads the scenario's robot and computes its trim.

        Raises:
            ScenarioError: if the robot cannot fly, or the working configuration does not fit it.
        """
        with file_at(scenario.source, "vehicle.robot"):
            description = RobotDescription.read(scenario.vehicle.robot)
            plant, scene_graph = make_nominal_plant(description)
            base, tool = plant.GetFrameByName(BASE_FRAME), plant.GetFrameByName(TOOL_FRAME)
            names = tuple(joint.name() for joint in arm_joints(plant))
            rotors = Rotors.of(plant, base.body(), description.robot)
        n, working = len(names), np.array(scenario.vehicle.working_rad, dtype=float)
        lower, upper = plant.GetPositionLowerLimits()[-n:], plant.GetPositionUpperLimits()[-n:]
        _check_working(working, lower, upper, names, scenario.source)

        context = plant.CreateDefaultContext()
        q = plant.GetDefaultPositions()
        q[BASE_POSITIONS:] = working
        plant.SetPositions(context, q)
        M = plant.CalcMassMatrix(context)
        arm_inertia = reduced_inertia(M)
        with file_at(scenario.source, "vehicle.robot"):
            _check_inertia(np.diag(M), np.diag(arm_inertia), names, description.robot)
        _check_overlap(plant, scene_graph, q, scenario.source)
        X_BE = plant.CalcRelativeTransform(context, base, tool)
        inertia = plant.CalcSpatialInertia(
            context, base, plant.GetBodyIndices(base.model_instance())
        )
        gravity = plant.CalcGravityGeneralizedForces(context)
        vehicle = cls(
            source=scenario.source,
            description=description,
            plant=plant,
            ground_geometry=GroundGeometry(plant, scene_graph, BASE_FRAME),
            joint_names=names,
            lower=lower,
            upper=upper,
            velocity=plant.GetVelocityUpperLimits()[-n:],
            acceleration=plant.GetAccelerationUpperLimits()[-n:],
            effort=plant.GetEffortUpperLimits(),
            rotors=rotors,
            p_B=np.array(scenario.vehicle.base_position_m),
            working=working,
            p_O=X_BE.translation(),
            tool_axis=X_BE.rotation().multiply(TOOL_AXIS),
            mass=inertia.get_mass(),
            inertia=inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3(),
            arm_inertia=arm_inertia,
            joint_damping=np.array([joint.default_damping() for joint in arm_joints(plant)]),
            trim_wrench=-gravity[[5, 0, 1, 2]],  # Generalized forces are [torque, force].
            trim_torque=-gravity[BASE_VELOCITIES:],
        )
        vehicle._check_start()
        return vehicle

    def _check_start(self) -> None:
        """Raises ScenarioError if the vehicle starts in the ground, or a joint is too weak."""
        heights = self.ground_geometry.heights(self.working)
        lowest = heights.min(initial=self.feet_m)
        if self.p_B[2] + lowest < -ROUNDING_M:
            raise ScenarioError(
                self.source,
                "vehicle.base_position_m[2]",
                f"expected {-lowest:.4g} m or more, so that feet and arm are above the ground, "
                f"got {self.p_B[2]:.4g} m",
            )
        for i, name in enumerate(self.joint_names):
            if abs(self.trim_torque[i]) > self.effort[i]:
                raise ScenarioError(
                    self.source,
                    "vehicle.working_rad",
                    f"expected angles at which {name} holds the arm with {self.effort[i]:.4g} N m "
                    f"or less, got {abs(self.trim_torque[i]):.4g} N m",
                )


def _check_inertia(
    masses: np.ndarray, inertias: np.ndarray, names: Sequence[str], robot: str
) -> None:
    """Raises BadInput if the base, or a joint with the links beyond it, has no inertia.

    Args:
        masses: (6 + n,) kg m^2 and kg, diagonal of the mass matrix.
        inertias: (n,) kg m^2, of the joints with a free base.
        names: Names of the joints.
        robot: The URDF, for messages.
    """
    places = [*["the base and the arm"] * BASE_VELOCITIES, *names]
    for place, inertia in zip(places, masses, strict=True):
        if not LIGHTEST < inertia < HEAVIEST:
            problem = "expected links with masses and inertias that can be moved"
            got = f"got {inertia:.4g} kg or kg m^2 at {place}"
            raise BadInput(robot, "", f"{problem}, {got}")
    for name, inertia in zip(names, inertias, strict=True):
        if not inertia > LIGHTEST:
            problem = "expected links beyond it with a moment of inertia about its axis"
            raise BadInput(robot, f"joint {name}", f"{problem}, got {inertia:.4g} kg m^2")


def _check_overlap(
    plant: MultibodyPlant, scene_graph: SceneGraph, positions: np.ndarray, source: str
) -> None:
    """Raises ScenarioError if collision geometry of the robot overlaps at its positions."""
    overlap = deepest_overlap(plant, scene_graph, positions)
    if overlap is not None and overlap.depth > ROUNDING_M:
        first, second = overlap.links
        raise ScenarioError(
            source,
            "vehicle.working_rad",
            f"expected angles at which the links do not collide, got collision geometry of {first} "
            f"{1000 * overlap.depth:.3g} mm deep in {second}; if that is harmless, list both in a "
            "<drake:collision_filter_group> of the URDF",
        )


def _check_working(
    working: np.ndarray, lower: np.ndarray, upper: np.ndarray, names: Sequence[str], source: object
) -> None:
    """Raises ScenarioError if the working configuration does not fit the joints."""
    key = "vehicle.working_rad"
    if len(working) != len(names):
        raise ScenarioError(
            source,
            key,
            f"expected {len(names)} angles in rad, one for each joint "
            f"({', '.join(names)}), got {len(working)}",
        )
    for i, name in enumerate(names):
        if not lower[i] <= working[i] <= upper[i]:
            raise ScenarioError(
                source,
                f"{key}[{i}]",
                f"expected {name} in [{lower[i]:.4g}, {upper[i]:.4g}] rad, got {working[i]:.4g}",
            )

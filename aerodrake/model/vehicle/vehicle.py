"""The vehicle as its URDF has it: joints, limits, rotors, inertia and trim."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from importlib import resources

import numpy as np
from pydrake.geometry import Box, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from aerodrake.model.vehicle.arm import HEAVIEST, LIGHTEST, arm_joints
from aerodrake.model.vehicle.mismatch import EXACT, mismatched_urdf
from aerodrake.model.vehicle.rotors import Rotors
from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES, VehicleState
from aerodrake.model.vehicle.tucking import GroundGeometry, tuck
from aerodrake.scenario import Mismatch, Scenario
from aerodrake.support.errors import BadInput, ScenarioError, file_at
from aerodrake.support.files import locate
from aerodrake.support.urdf import SUFFIX

BASE_FRAME = "base"
"""The base's link in the URDF, whose frame is B."""
TOOL_FRAME = "tool"
"""The tool's frame in the URDF, whose origin is the end-effector, E."""
TOOL_AXIS = np.array([0.0, 0.0, -1.0])
"""Where the tool points, in its frame: the direction in which it approaches things."""
GRAVITY = 9.81
"""m/s^2, Drake's default."""
ROUNDING_M = 1e-6
"""What feet on the ground may be below it."""


def add_robot(plant: MultibodyPlant, robot: str, mismatch: Mismatch = EXACT) -> None:
    """Parses a robot into an unfinalised plant.

    Args:
        plant: Where the robot goes.
        robot: A `package://aerodrake/...` URI, or the path of a URDF.
        mismatch: How its links are off what is written there.

    Raises:
        BadInput: if the file is missing, is no URDF, or lacks the frames
            `base` and `tool`.
    """
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(resources.files("aerodrake") / "package.xml"))
    try:
        parser.AddModelsFromString(mismatched_urdf(locate(robot), mismatch), SUFFIX)
    except BadInput as error:
        raise BadInput(robot, *error.args[1:]) from None
    except (RuntimeError, ValueError, SystemExit) as error:  # Drake's own, and its conditions.
        problem = re.sub(r"<literal-string>\S*: error: ", "", str(error))
        raise BadInput(robot, "", f"cannot be parsed: {problem}") from None
    for frame in (BASE_FRAME, TOOL_FRAME):
        if not plant.HasFrameNamed(frame):
            raise BadInput(robot, "", f"expected a frame named '{frame}'")
    if not plant.HasBodyNamed(BASE_FRAME):
        raise BadInput(robot, "", f"expected '{BASE_FRAME}' to be a link")


def add_ground(plant: MultibodyPlant) -> None:
    """Adds ground at z = 0 to a plant that is registered with a SceneGraph."""
    slab = Box(100.0, 100.0, 1.0)
    pose = RigidTransform([0.0, 0.0, -0.5])
    friction = CoulombFriction(static_friction=0.8, dynamic_friction=0.6)
    plant.RegisterCollisionGeometry(plant.world_body(), pose, slab, "ground_collision", friction)


@dataclass(frozen=True)
class VehicleModel:
    """Facts about the robot, all read from its URDF, and its trim.

    Attributes:
        source: The scenario it belongs to, for messages.
        robot: The URI or path it was read from.
        joint_names: Of the n arm joints, from the base to the tool.
        lower, upper: (n,) rad, joint position limits.
        velocity: (n,) rad/s, joint velocity limits.
        acceleration: (n,) rad/s^2, joint acceleration limits.
        effort: (n,) N m, joint torque limits.
        rotors: Where the rotors are.
        p_B: (3,) m, where the base starts.
        working: (n,) rad, the working configuration.
        p_O: (3,) m, the tool there, in the base frame: centre of the learning space.
        tool_axis: (3,) where the tool points there, in the base frame.
        mass: kg, base and arm.
        inertia: (3, 3) kg m^2, of base and arm in the working configuration,
            about their common centre of mass, in the base frame.
        joint_inertia: (n,) kg m^2, that each joint feels there with the base free.
        trim_wrench: (4,) [N, N m, N m, N m], what the rotors give in hover there.
        trim_torque: (n,) N m, what the joints hold there.
        feet_m: m, the base's lowest point in its frame: on that it stands.
    """

    source: str
    robot: str
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
    joint_inertia: np.ndarray
    trim_wrench: np.ndarray
    trim_torque: np.ndarray
    feet_m: float

    @property
    def joints(self) -> int:
        """n, the number of arm joints."""
        return len(self.joint_names)

    @property
    def p_E(self) -> np.ndarray:
        """(3,) m, where the end-effector starts."""
        return self.p_B + self.p_O

    @property
    def trim_state(self) -> np.ndarray:
        """(13 + 2 n,) the state in which flights start, as `VehicleState` has it."""
        level, still = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
        rest = np.zeros(self.joints)
        return VehicleState(level, self.p_B, self.working, still, still, rest).to_vector()

    @cached_property
    def tucked(self) -> np.ndarray:
        """(n,) rad, where the arm goes for a landing, as `tuck` finds it."""
        plant, scene_graph = _parsed(self.robot)
        return tuck(GroundGeometry(plant, scene_graph, BASE_FRAME), self.working)

    def per_joint(self, values: tuple[float, ...], key: str) -> np.ndarray:
        """(n,), from a scenario's list of one value, or of one per joint.

        Raises:
            ScenarioError: if the list has another length.
        """
        if len(values) not in (1, self.joints):
            raise ScenarioError(
                self.source,
                key,
                f"expected 1 value, or {self.joints}, one for each joint, got {len(values)}",
            )
        return np.broadcast_to(np.array(values, dtype=float), self.joints)

    @classmethod
    def load(cls, scenario: Scenario) -> VehicleModel:
        """Reads the scenario's robot and computes its trim.

        Raises:
            ScenarioError: if it cannot be flown, or the working configuration does not fit it.
        """
        robot, working = scenario.vehicle.robot, scenario.vehicle.working_rad
        with file_at(scenario.source, "vehicle.robot"):
            plant, scene_graph = _parsed(robot)
            base, tool = plant.GetFrameByName(BASE_FRAME), plant.GetFrameByName(TOOL_FRAME)
            joints = arm_joints(plant, base.body(), tool.body(), robot)
            rotors = Rotors.of(plant, plant.GetBodyByName(BASE_FRAME), robot)
        n = len(joints)
        lower, upper = plant.GetPositionLowerLimits()[-n:], plant.GetPositionUpperLimits()[-n:]
        _check_working(np.array(working), lower, upper, [j.name() for j in joints], scenario.source)

        context = plant.CreateDefaultContext()
        q = plant.GetDefaultPositions()
        q[BASE_POSITIONS:] = working
        plant.SetPositions(context, q)
        X_BE = plant.CalcRelativeTransform(context, base, tool)
        inertia = plant.CalcSpatialInertia(
            context, base, plant.GetBodyIndices(base.model_instance())
        )
        gravity = plant.CalcGravityGeneralizedForces(context)
        M = plant.CalcMassMatrix(context)
        b, a = slice(BASE_VELOCITIES), slice(BASE_VELOCITIES, None)
        felt = np.zeros((n, n))
        if np.all((np.diag(M) > LIGHTEST) & (np.diag(M) < HEAVIEST)):
            felt = M[a, a] - M[a, b] @ np.linalg.solve(M[b, b], M[b, a])
        if not np.all(np.diag(felt) > LIGHTEST):
            problem = f"{robot}: expected links of masses and inertias that can be moved"
            raise ScenarioError(scenario.source, "vehicle.robot", problem)
        geometry = GroundGeometry(plant, scene_graph, BASE_FRAME)
        vehicle = cls(
            source=scenario.source,
            robot=robot,
            joint_names=tuple(j.name() for j in joints),
            lower=lower,
            upper=upper,
            velocity=plant.GetVelocityUpperLimits()[-n:],
            acceleration=plant.GetAccelerationUpperLimits()[-n:],
            effort=plant.GetEffortUpperLimits(),
            rotors=rotors,
            p_B=np.array(scenario.vehicle.base_position_m),
            working=np.array(working, dtype=float),
            p_O=X_BE.translation(),
            tool_axis=X_BE.rotation().multiply(TOOL_AXIS),
            mass=inertia.get_mass(),
            inertia=inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3(),
            joint_inertia=np.diag(felt).copy(),
            trim_wrench=-gravity[[5, 0, 1, 2]],  # Generalized forces are [torque, force].
            trim_torque=-gravity[a],
            feet_m=geometry.feet,
        )
        vehicle._check_start(geometry.heights(vehicle.working).min(initial=geometry.feet))
        return vehicle

    def _check_start(self, lowest: float) -> None:
        """Refuses to start in the ground, lowest m below the base's origin, or with a limp arm."""
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


def _parsed(robot: str) -> tuple[MultibodyPlant, SceneGraph]:
    """The robot by itself, and its geometry."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, robot)
    plant.Finalize()
    return plant, scene_graph


def _check_working(
    working: np.ndarray, lower: np.ndarray, upper: np.ndarray, names: list[str], source: object
) -> None:
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

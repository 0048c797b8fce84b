"""Checks of a robot's arm: revolute joints in series, driven and limited."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, RigidBody

from aerodrake.model.vehicle.state import BASE_POSITIONS, BASE_VELOCITIES
from aerodrake.support.errors import BadInput

LIGHTEST, HEAVIEST = 1e-9, 1e9
"""Bounds of all positive quantities: masses, moments of inertia, and ranges of joints."""


def arm_joints(
    plant: MultibodyPlant, base: RigidBody, tool: RigidBody, robot: str
) -> list[RevoluteJoint]:
    """Returns the joints of a robot's arm, from the base to the tool.

    Args:
        plant: The finalised plant, which contains the robot alone.
        base, tool: The first and the last link of the arm.
        robot: URI or path of the robot, for messages.

    Raises:
        BadInput: if the arm is not a series of revolute joints on a free base, or a joint
            lacks limits or a transmission.
    """
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    arm = [j for j in joints if isinstance(j, RevoluteJoint)]
    arm.sort(key=lambda joint: joint.position_start())  # The file may have another order.
    if (
        not arm
        or plant.num_positions() != BASE_POSITIONS + len(arm)
        or not _is_chain(plant, base, arm, tool)
    ):
        raise BadInput(
            robot, "", "expected a free base and, from it to the tool, revolute joints in series"
        )
    driven = [plant.get_joint_actuator(i).joint().name() for i in plant.GetJointActuatorIndices()]
    if driven != [j.name() for j in arm]:
        names = ", ".join(j.name() for j in arm)
        raise BadInput(robot, "", f"expected one transmission per joint, in this order: {names}")
    lower = plant.GetPositionLowerLimits()[BASE_POSITIONS:]
    upper = plant.GetPositionUpperLimits()[BASE_POSITIONS:]
    positive = [
        upper - lower,
        plant.GetEffortUpperLimits(),
        plant.GetVelocityUpperLimits()[BASE_VELOCITIES:],
        plant.GetAccelerationUpperLimits()[BASE_VELOCITIES:],
    ]
    is_limited = np.all((np.array(positive) > LIGHTEST) & (np.array(positive) < HEAVIEST), axis=0)
    if not is_limited.all():
        raise BadInput(
            robot,
            "",
            f"{arm[int(np.argmin(is_limited))].name()}: expected every joint to have limits of "
            "position, effort, velocity and drake:acceleration, all with room to move",
        )
    return arm


def _is_chain(
    plant: MultibodyPlant, base: RigidBody, arm: list[RevoluteJoint], tool: RigidBody
) -> bool:
    """Returns True if the joints connect the base to the tool in this order."""
    parents = [base, *(j.child_body() for j in arm)]
    children = [*(j.parent_body() for j in arm), tool]
    return all(
        child in plant.GetBodiesWeldedTo(parent)
        for parent, child in zip(parents, children, strict=True)
    )

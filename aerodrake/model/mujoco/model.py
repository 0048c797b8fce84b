"""Model of a vehicle in MuJoCo, made from Drake's plant of it."""

from mujoco import MjModel, MjsBody, MjSpec, mjtDisableBit, mjtJoint, mjtLimited, mjtTrn
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Joint, RevoluteJoint, RigidBody, WeldJoint

from aerodrake.model.mujoco.geometry import add_contacts
from aerodrake.model.vehicle.robot import BASE_FRAME
from aerodrake.model.vehicle.rotors import Rotors

STATELESS = mjtDisableBit.mjDSBL_WARMSTART | mjtDisableBit.mjDSBL_AUTORESET
"""Disables the constraint solver's warm start, a state beside positions and velocities, and the
reset of states that are not finite."""


def make_mujoco_model(
    plant: MultibodyPlant, scene_graph: SceneGraph | None, rotors: Rotors, torque_ratio: float
) -> MjModel:
    """Makes MuJoCo's model of the vehicle in a plant.

    URDF, model mismatch, payload and ground are put together in the plant, so that both engines
    have the same bodies, inertias, joints, limits, and geometry that may touch.

    Args:
        plant: Finalised plant of vehicle and ground.
        scene_graph: Their collision geometry; None if nothing can touch.
        rotors: The rotors, which become actuators in their order; controls are thrusts in N.
        torque_ratio: m, drag torque of a rotor over its thrust.
    """
    spec = MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = plant.gravity_field().gravity_vector()
    spec.option.disableflags = STATELESS
    bodies = _add_bodies(spec, plant)
    if scene_graph is not None:
        add_contacts(spec, bodies, plant, scene_graph.model_inspector())
    base = bodies[plant.GetBodyByName(BASE_FRAME).index()]
    for name, p_B, spin in zip(rotors.names, rotors.p_B, rotors.spin, strict=True):
        base.add_site(name=name, pos=p_B)
        spec.add_actuator(
            name=name,
            target=name,
            trntype=mjtTrn.mjTRN_SITE,
            gear=[0, 0, 1, 0, 0, -spin * torque_ratio],
        )
    return spec.compile()


def body_numbers(model: MjModel, plant: MultibodyPlant) -> list[int]:
    """Returns the numbers in a model of the plant's bodies, in the plant's order."""
    bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
    return [0, *(model.body(_name(body)).id for body in bodies)]


def _name(body: RigidBody) -> str:
    return body.scoped_name().get_full()


def _add_bodies(spec: MjSpec, plant: MultibodyPlant) -> dict[BodyIndex, MjsBody]:
    """Adds the plant's bodies and joints to a specification, and returns its bodies by index."""
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    inboard = {joint.child_body().index(): joint for joint in joints}
    actuators = map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
    armature = {a.joint().index(): a.default_reflected_inertia() for a in actuators}
    bodies = {plant.world_body().index(): spec.worldbody}

    def add(body: RigidBody) -> MjsBody:
        """Adds a body after those between it and the world."""
        if (index := body.index()) not in bodies:
            joint = inboard[index]
            bodies[index] = _add_body(add(joint.parent_body()), body, joint)
            if isinstance(joint, RevoluteJoint):
                _add_hinge(bodies[index], joint, armature[joint.index()])
            elif not isinstance(joint, WeldJoint):
                bodies[index].add_freejoint()
        return bodies[index]

    for i in range(plant.num_bodies()):
        add(plant.get_body(BodyIndex(i)))
    return bodies


def _add_body(parent: MjsBody, body: RigidBody, joint: Joint) -> MjsBody:
    """Adds a body to its parent, with its pose at zero joint angle, mass and inertia."""
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
    X_BM = joint.frame_on_child().GetFixedPoseInBodyFrame()
    X_PB = X_PF @ X_BM.inverse()
    inertia = body.default_spatial_inertia()
    centre = inertia.get_com()
    central = inertia.Shift(centre).CalcRotationalInertia()
    moments, R_BA = central.CalcPrincipalMomentsAndAxesOfInertia()
    moments[2] = min(moments[2], moments[0] + moments[1])  # Up to rounding, as MuJoCo expects.
    return parent.add_body(
        name=_name(body),
        pos=X_PB.translation(),
        quat=X_PB.rotation().ToQuaternion().wxyz(),
        explicitinertial=True,
        mass=inertia.get_mass(),
        ipos=centre,
        iquat=R_BA.ToQuaternion().wxyz(),
        inertia=moments,
    )


def _add_hinge(body: MjsBody, joint: RevoluteJoint, armature: float) -> None:
    """Adds a revolute joint with its limits, damping and reflected rotor inertia."""
    X_BM = joint.frame_on_child().GetFixedPoseInBodyFrame()
    body.add_joint(
        name=joint.name(),
        type=mjtJoint.mjJNT_HINGE,
        pos=X_BM.translation(),
        axis=X_BM.rotation().multiply(joint.revolute_axis()),
        damping=joint.default_damping(),
        armature=armature,
        limited=mjtLimited.mjLIMITED_TRUE,
        range=[joint.position_lower_limit(), joint.position_upper_limit()],
    )

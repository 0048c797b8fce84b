"""Vehicles in both physics engines, and random states and forces of them."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from pydrake.geometry import GeometryId, PenetrationAsPointPair, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces
from pydrake.systems.framework import Context

from aerodrake.model.mujoco.engine import MujocoEngine
from aerodrake.model.mujoco.model import make_mujoco_model
from aerodrake.model.vehicle.robot import add_ground, add_payload, add_robot, make_scene_graph
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from tests.robots import at

PERIOD_S = 1e-3
"""Step of both engines."""


class Forces(NamedTuple):
    """Rotor thrusts, joint torques, and the generalized force on [omega_W, v_B, q']."""

    thrust: np.ndarray
    torque: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class BothEngines:
    """One vehicle in both engines.

    Attributes:
        vehicle: Its model.
        torque_ratio: m, of its rotors.
        plant: Drake's plant, with mismatch, payload and ground.
        scene_graph: Its geometry.
        engine: MuJoCo's, of the same plant.
    """

    vehicle: VehicleModel
    torque_ratio: float
    plant: MultibodyPlant
    scene_graph: SceneGraph
    engine: MujocoEngine

    @classmethod
    def make(cls, scenario: Scenario, integrator: str = "rk4") -> Self:
        vehicle, ratio = VehicleModel.load(scenario), scenario.vehicle.rotor.torque_ratio_m
        plant, scene_graph = MultibodyPlant(PERIOD_S), make_scene_graph()
        plant.RegisterAsSourceForSceneGraph(scene_graph)
        add_robot(plant, vehicle.description, scenario.mismatch)
        add_payload(plant, scenario.payload.mass_kg)
        add_ground(plant)
        plant.Finalize()
        model = make_mujoco_model(plant, scene_graph, vehicle.rotors, ratio)
        engine = MujocoEngine(model, PERIOD_S, integrator)
        return cls(vehicle, ratio, plant, scene_graph, engine)

    def random_state(self, rng: np.random.Generator) -> np.ndarray:
        """Returns a state above the ground, at any attitude, with joints within their limits."""
        quaternion, n = rng.normal(size=4), self.vehicle.joints
        quaternion /= np.linalg.norm(quaternion)
        q = rng.uniform(self.vehicle.lower, self.vehicle.upper)
        p_B = rng.normal(size=3) + [0, 0, 9]
        return VehicleState(
            quaternion, p_B, q, rng.normal(size=3), rng.normal(size=3), rng.normal(size=n)
        ).to_vector()

    def random_forces(self, rng: np.random.Generator) -> Forces:
        """Returns forces on all rotors and joints and on the base."""
        n, k = self.vehicle.joints, len(self.vehicle.rotors.spin)
        return Forces(10 * rng.random(k), rng.normal(size=n), rng.normal(size=6 + n))

    def drake_accelerations(self, x: np.ndarray, forces: Forces) -> np.ndarray:
        """Returns v' (6 + n,) in Drake, with the rotors' forces at their frames in the URDF."""
        plant, context = self.plant, at(self.plant, x)
        tau = np.concatenate([np.zeros(6), forces.torque]) + forces.force
        for name, spin, thrust in zip(
            self.vehicle.rotors.names, self.vehicle.rotors.spin, forces.thrust, strict=True
        ):
            axis = plant.GetFrameByName(name).CalcRotationMatrixInWorld(context).col(2)
            wrench = np.concatenate([-spin * self.torque_ratio * thrust * axis, thrust * axis])
            tau += self.jacobian(context, name).T @ wrench
        applied = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, applied)  # Gravity and joint damping.
        bias = plant.CalcInverseDynamics(context, np.zeros(len(tau)), applied)
        return np.linalg.solve(plant.CalcMassMatrix(context), tau - bias)

    def penetrations(self, x: np.ndarray) -> list[PenetrationAsPointPair]:
        """Returns Drake's pairs of geometry that penetrate each other at a state."""
        plant, scene = self.plant, self.scene_graph.CreateDefaultContext()
        poses = plant.get_geometry_pose_output_port().Eval(at(plant, x))
        self.scene_graph.get_source_pose_port(plant.get_source_id()).FixValue(scene, poses)
        query = self.scene_graph.get_query_output_port().Eval(scene)
        return query.ComputePointPairPenetration()

    def body_index(self, geometry: GeometryId) -> int:
        """Returns the index of the body that a geometry is fixed to."""
        frame = self.scene_graph.model_inspector().GetFrameId(geometry)
        return int(self.plant.GetBodyFromFrameId(frame).index())

    def jacobian(self, context: Context, frame: str) -> np.ndarray:
        """Returns the Jacobian (6, 6 + n) of a frame in the world, rotation first."""
        world = self.plant.world_frame()
        return self.plant.CalcJacobianSpatialVelocity(
            context,
            JacobianWrtVariable.kV,
            self.plant.GetFrameByName(frame),
            np.zeros(3),
            world,
            world,
        )


def from_mujoco(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Returns velocities or accelerations (6 + n,) of MuJoCo in Drake's order and frames."""
    R_B = VehicleState(x[:4], *[np.empty(0)] * 5).R_B
    return np.concatenate([R_B @ v[3:6], v[:3], v[6:]])

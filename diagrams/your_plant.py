"""Replaces the packaged plant by your own: the equations of motion, integrated in Python."""

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import LeafSystem

import aerodrake
from aerodrake.model.vehicle.vehicle import VehicleModel


class YourPlant(LeafSystem):
    """Free flight by semi-implicit Euler steps, without contact, payload or mismatch.

    Ports: those of `aerodrake.wiring.plant.make_plant`, without `body_poses`, which is optional.
    Rate: `step_s`.
    """

    def __init__(self, vehicle: VehicleModel, torque_ratio_m: float, step_s: float):
        super().__init__()
        self._vehicle, self._plant, self._step_s = vehicle, vehicle.plant, step_s
        self._context = vehicle.plant.CreateDefaultContext()  # Of the equations, without a state.
        self._mixer = vehicle.rotors.mixer(torque_ratio_m)  # To [thrust, torque x, y, z].
        self._thrust = self.DeclareVectorInputPort("thrust", self._mixer.shape[1])
        self._torque = self.DeclareVectorInputPort("joint_torque", vehicle.joints)
        self._force = self.DeclareVectorInputPort("generalized_force", 6 + vehicle.joints)
        state = self.DeclareDiscreteState(vehicle.trim_state)
        self.DeclareStateOutputPort("state", state)
        self.DeclarePeriodicDiscreteUpdateEvent(step_s, 0.0, self._update)

    def _update(self, context, discrete) -> None:
        plant, own = self._plant, self._context
        x = context.get_discrete_state_vector().value()
        R = aerodrake.split_state(x).R_B
        lift, *torque = self._mixer @ self._thrust.Eval(context)
        limit = self._vehicle.effort
        applied = self._force.Eval(context) + [
            *R @ torque,
            *lift * R[:, 2],
            *np.clip(self._torque.Eval(context), -limit, limit),
        ]
        plant.SetPositionsAndVelocities(own, x)
        q, v = plant.GetPositions(own), plant.GetVelocities(own)
        damping = MultibodyForces(plant)
        plant.CalcForceElementsContribution(own, damping)
        bias = plant.CalcInverseDynamics(own, np.zeros(len(v)), damping)
        v = v + self._step_s * np.linalg.solve(plant.CalcMassMatrix(own), applied - bias)
        q = q + self._step_s * plant.MapVelocityToQDot(own, v)
        q[:4] /= np.linalg.norm(q[:4])
        discrete.set_value([*q, *v])


def main() -> None:
    scenario = aerodrake.load_scenario("clover", duration=2, settle_s=0.5)
    vehicle, ratio = VehicleModel.load(scenario), scenario.vehicle.rotor.torque_ratio_m
    yours = {"plant": lambda packaged: YourPlant(vehicle, ratio, scenario.rates.plant_step_s)}
    for name, replaced in (("packaged", {}), ("yours", yours)):
        result = aerodrake.fly(scenario, replacements=aerodrake.Replacements(replaced))
        print(f"{name}: {1e3 * result.error['mean_m']:.4f} mm, {result.exit_reason}")


if __name__ == "__main__":
    main()

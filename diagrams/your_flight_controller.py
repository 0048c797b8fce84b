"""Replaces the packaged flight controller by your own: PD control on SE(3), without an observer."""

import numpy as np
from pydrake.systems.framework import LeafSystem

import aerodrake
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel


class PdController(LeafSystem):
    """PD control of position and attitude, with the model's trim torque as feedforward.

    Ports: those of `aerodrake.systems.flight_controller.FlightController`.
    Rate: `period`, half a millisecond after each sample.
    """

    def __init__(self, vehicle: VehicleModel, torque_ratio: float, period: float):
        super().__init__()
        self._vehicle = vehicle
        self._mixer = np.linalg.pinv(vehicle.rotors.mixer(torque_ratio))
        self._state = self.DeclareVectorInputPort("state", 13 + 2 * vehicle.joints)
        self._setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self.DeclareVectorInputPort("joint_setpoint", 3 * vehicle.joints)
        thrust = self.DeclareDiscreteState(self._mixer @ vehicle.trim_wrench)
        self.DeclareStateOutputPort("thrust_command", thrust)
        specific_thrust = self.DeclareDiscreteState([GRAVITY])
        self.DeclareStateOutputPort("specific_thrust", specific_thrust)
        for name, size in (("acceleration", 6), ("reaction", 3), ("disturbance", 6)):
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(size))  # Zero: no observer.
        self.DeclareStateOutputPort("saturated", self.DeclareDiscreteState(1))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0005, self._update)

    def _update(self, context, discrete) -> None:
        x = aerodrake.split_state(self._state.Eval(context))
        p_d, v_d, a_d = self._setpoint.Eval(context).reshape(3, 3)
        a = a_d + 9.0 * (p_d - x.p_B) + 5.0 * (v_d - x.v_B) + [0.0, 0.0, GRAVITY]
        R, z = x.R_B, a / np.linalg.norm(a)
        y = np.cross(z, [1.0, 0.0, 0.0]) / np.linalg.norm(np.cross(z, [1.0, 0.0, 0.0]))
        R_d = np.column_stack([np.cross(y, z), y, z])
        error = 0.5 * (R_d.T @ R - R.T @ R_d)[[2, 0, 1], [1, 2, 0]]  # Lee et al., 2010.
        alpha = -144.0 * error - 24.0 * (R.T @ x.omega_W)
        torque = self._vehicle.inertia @ alpha + self._vehicle.trim_wrench[1:]
        thrust = self._vehicle.mass * (a @ R[:, 2])
        discrete.set_value(0, self._mixer @ [thrust, *torque])
        discrete.set_value(1, [a @ R[:, 2]])


def main() -> None:
    scenario = aerodrake.load_scenario("clover", duration=8)
    vehicle = VehicleModel.load(scenario)
    ratio, period = scenario.vehicle.rotor.torque_ratio_m, scenario.rates.flight_period_s
    pd = {"flight_controller": lambda packaged: PdController(vehicle, ratio, period)}
    for name, replaced in (("packaged", {}), ("PD", pd)):
        result = aerodrake.fly(scenario, replacements=aerodrake.Replacements(replaced))
        print(f"{name}: {1e3 * result.error['mean_m']:.3f} mm")


if __name__ == "__main__":
    main()

"""Simulates the coordinator without a plant, with a constant measured state."""

import numpy as np
from pydrake.systems.analysis import Simulator

import aerodrake
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.support.threads import single_thread


def main() -> None:
    scenario = aerodrake.load_scenario("moving_target")
    coordinator = aerodrake.make_coordinator(scenario)
    context = aerodrake.make_context(coordinator, scenario.seed)
    for port, value in (
        ("state", VehicleModel.load(scenario).trim_state),
        ("specific_thrust", [GRAVITY]),
        ("external_acceleration", np.zeros(3)),
        ("disturbance", np.zeros(6)),
        ("saturated", [0.0]),
    ):
        coordinator.GetInputPort(port).FixValue(context, value)
    simulator = Simulator(coordinator, context)
    for t in (0.0, 0.1, 0.2, 0.5, 1.0):
        with single_thread():
            simulator.AdvanceTo(scenario.settle_s + t)
        p_d, v_d, _ = coordinator.GetOutputPort("base_setpoint").Eval(context).reshape(3, 3)
        print(f"{t:.1f} s  p_d {p_d.round(3)} m  v_d {v_d.round(3)} m/s")


if __name__ == "__main__":
    main()

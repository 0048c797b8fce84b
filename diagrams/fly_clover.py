"""Builds the closed loop, flies ten seconds of the clover and prints the error."""

import numpy as np
from pydrake.systems.analysis import Simulator

import aerodrake
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.threads import single_thread


def main() -> None:
    scenario = aerodrake.load_scenario("clover")
    closed_loop = aerodrake.make_closed_loop(scenario)
    context = aerodrake.make_context(closed_loop, scenario.seed)
    simulator = Simulator(closed_loop, context)
    kinematics = Kinematics(VehicleModel.load(scenario).plant)
    for t in range(11):
        with single_thread():
            simulator.AdvanceTo(scenario.settle_s + t)
        state = aerodrake.split_state(closed_loop.GetOutputPort("true_state").Eval(context))
        p_Ed = closed_loop.GetOutputPort("reference").Eval(context)[:3]
        error = np.linalg.norm(kinematics.end_effector(state).p_E - p_Ed)
        x, y, z = p_Ed
        print(f"{t:3d} s  p_E,d {x:6.3f} {y:6.3f} {z:6.3f} m  error {1e3 * error:.2f} mm")


if __name__ == "__main__":
    main()

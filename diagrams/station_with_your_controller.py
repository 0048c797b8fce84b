"""Flies the station alone with a controller of your own: here, a circle of the base."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

import aerodrake
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.threads import single_thread


class Circle(LeafSystem):
    """Source of p_d, v_d and a_d on a circle of 0.3 m about `centre` (3,) m, 8 s a turn."""

    def __init__(self, centre: np.ndarray):
        super().__init__()
        self._centre = centre
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc, {self.time_ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        radius, rate = 0.3, 2 * np.pi / 8
        angle = rate * context.get_time()
        radial = radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        tangential = radius * np.array([-np.sin(angle), np.cos(angle), 0.0])
        p_d, v_d, a_d = self._centre + radial, rate * tangential, -(rate**2) * radial
        output.SetFromVector([*p_d, *v_d, *a_d])


def main() -> None:
    scenario = aerodrake.Scenario()
    vehicle = VehicleModel.load(scenario)
    builder = DiagramBuilder()
    station = builder.AddSystem(aerodrake.make_station(scenario))
    circle = builder.AddNamedSystem("circle", Circle(vehicle.p_B))
    arm = builder.AddNamedSystem(
        "arm", ConstantVectorSource([*vehicle.working, *np.zeros(2 * vehicle.joints)])
    )
    builder.Connect(circle.get_output_port(), station.GetInputPort("base_setpoint"))
    builder.Connect(arm.get_output_port(), station.GetInputPort("joint_setpoint"))
    diagram = builder.Build()

    context = aerodrake.make_context(diagram, seed=0)
    simulator = Simulator(diagram, context)
    for t in range(0, 13, 2):
        with single_thread():
            simulator.AdvanceTo(t)
        x = station.GetOutputPort("true_state").Eval(station.GetMyContextFromRoot(context))
        p_B = aerodrake.split_state(x).p_B
        p_Bd = circle.get_output_port().Eval(circle.GetMyContextFromRoot(context))[:3]
        print(f"{t:3d} s  base at {p_B.round(3)} m, setpoint {p_Bd.round(3)} m")


if __name__ == "__main__":
    main()

"""The station with prescribed setpoints, without a coordinator."""

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import Trajectory

from aerodrake.scenario import Scenario
from aerodrake.station import make_station


def make_open_loop(scenario: Scenario, base: Trajectory, joints: Trajectory) -> Diagram:
    """Makes the station with two sources of setpoints in place of the coordinator.

    Outputs: all outputs of the station, and `base_setpoint` (9) and `joint_setpoint` (3 n).

    Args:
        scenario: The scenario of the station.
        base: (3,) m, p_d over time.
        joints: (n,) rad, q_d over time.
    """
    builder = DiagramBuilder()
    station = builder.AddSystem(make_station(scenario))
    for i in range(station.num_output_ports()):
        port = station.get_output_port(i)
        builder.ExportOutput(port, port.get_name())
    for port, trajectory in (("base_setpoint", base), ("joint_setpoint", joints)):
        source = builder.AddNamedSystem(port, TrajectorySource(trajectory, 2))
        builder.Connect(source.get_output_port(), station.GetInputPort(port))
        builder.ExportOutput(source.get_output_port(), port)
    diagram = builder.Build()
    diagram.set_name("open_loop")
    return diagram

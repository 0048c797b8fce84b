"""The station with prescribed setpoints, without a coordinator, and its flights."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import Trajectory

from aerodrake.model.residual.samples import Excitation
from aerodrake.scenario import Scenario
from aerodrake.station import make_context, make_station
from aerodrake.support.threads import single_thread


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


def excite(
    scenario: Scenario,
    base: Trajectory,
    joints: Trajectory,
    progress: Callable[[float], None] = lambda simulated_s: None,
) -> Excitation:
    """Flies the scenario's station from trim along both motions, to the end of `base`.

    Args:
        scenario: The scenario; its reference is not flown.
        base: (3,) m, p_d from time 0, at rest at its start.
        joints: (n,) rad, q_d likewise, for at least the same time.
        progress: Called with the simulated time in s as it advances.

    Raises:
        RuntimeError: if the plant cannot step, for example after a crash.
    """
    period, step = scenario.rates.mpc_period_s, scenario.rates.plant_step_s
    diagram = make_open_loop(scenario, base, joints)
    context = make_context(diagram, scenario.seed)
    simulator = Simulator(diagram, context)
    ticks = period * np.arange(round(base.end_time() / period) + 1)
    names = ("state", "specific_thrust", "external_acceleration", "disturbance")
    ports = [diagram.GetOutputPort(name) for name in names]
    rows: list[list[np.ndarray]] = []
    with single_thread():
        for tick in ticks:
            simulator.AdvanceTo(tick + step / 4)  # Just after the sample.
            rows.append([port.Eval(context).copy() for port in ports])
            progress(tick)
    measured = map(np.array, zip(*rows, strict=True))
    return Excitation(ticks, *measured, _setpoint(base, ticks), _setpoint(joints, ticks))


def _setpoint(motion: Trajectory, ticks: np.ndarray) -> np.ndarray:
    """Returns (T, 3 m): position, velocity and acceleration at the ticks."""
    orders = (motion, motion.MakeDerivative(1), motion.MakeDerivative(2))
    return np.hstack([order.vector_values(ticks).T for order in orders])

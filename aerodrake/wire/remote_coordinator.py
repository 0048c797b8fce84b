"""What stands in the coordinator's place where that is in another process.

    event                           period, offset (defaults)     kind
    sender                          10 ms, after 0.25 ms          publish
    receiver                         1 ms, after 0.375 ms         discrete
    receiver, setpoint_integrator   20 ms                         discrete
    supervisor                      10 ms                         discrete

A sample goes out when all that is due at its instant is done. The answer is there some
milliseconds later, after the low-level controllers have run: each message has the plan of
the next ticks with it, and so they already had what the one before foresaw. That makes up
for the time on the way: clover's lap, 0.020 mm without a wire, is at 0.019 mm or less with a
latency of 2 to 15 ms, and would be at 0.031 mm if setpoints just went on.
"""

from __future__ import annotations

from collections.abc import Callable

from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.framework import Diagram, DiagramBuilder, System

from aerodrake.coordinator import make_coordinator, make_setpoint_integrator, make_supervisor
from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import coordinated
from aerodrake.station import STATION_INTERFACE
from aerodrake.wire.link import Link
from aerodrake.wire.message import Layout
from aerodrake.wire.receiver import HORIZONS, WireReceiver
from aerodrake.wire.sender import WireSender

OWN = (
    *("base_setpoint", "joint_setpoint", "u", "mode", "cause", "conditions"),
    *(port for port, _ in HORIZONS.values()),
)
"""Outputs of the coordinator that the station's end of the wire computes itself."""


def make_layouts(coordinator: Diagram, scenario: Scenario) -> tuple[Layout, Layout]:
    """Of the station's messages, and of the coordinator's.

    Args:
        coordinator: Whose ports they are about.
        scenario: Theirs. As long as a plan is followed it is told, and no longer.

    Raises:
        ScenarioError: if a file that it names cannot be read.
    """
    agreed = coordinated(scenario)
    inputs = [coordinator.GetInputPort(name) for name in (*STATION_INTERFACE, "followed")]
    outputs = map(coordinator.get_output_port, range(coordinator.num_output_ports()))
    told = {p.get_name(): p.size() for p in outputs if p.get_name() not in OWN}
    ticks, axes = scenario.supervisor.plan_ticks + 2, told["segment"] // 3
    told["plan"] = min(told["plan"], ticks * axes)
    for name in HORIZONS.keys() & told.keys():
        told[name] = min(told[name], 6 * (ticks + 1))
    return (
        Layout(agreed, {port.get_name(): port.size() for port in inputs}),
        Layout(agreed, {**told, "tick_ms": 1, "output_time_s": 1}),
    )


def make_station_link(
    scenario: Scenario, lcm: DrakeLcmInterface, say: Callable[[str], None] = lambda note: None
) -> Link:
    """The station's end of the wire over `lcm`; `say` as `Link` has it."""
    return Link(lcm, *make_layouts(make_coordinator(scenario), scenario), True, say)


def make_remote_coordinator(scenario: Scenario, vehicle: VehicleModel, link: Link) -> Diagram:
    """Told by wire what to do, with setpoint integrator and supervisor of its own.

    These two stay with the vehicle: setpoints cannot jump, whatever comes over the wire or does
    not, and what no longer comes leads to the safe modes. To the integrator of the coordinator
    they are told as `followed`.

    Inputs and outputs: those of `make_coordinator`, but `followed`, `segment` as the
    station's, `plan` and the horizons.

    Args:
        scenario: That of the coordinator, as far as it is `fingerprint.COORDINATED`.
        vehicle: The scenario's vehicle.
        link: The station's end.
    """
    rates = scenario.rates
    step = rates.plant_step_s
    builder = DiagramBuilder()
    receiver = builder.AddNamedSystem(
        "receiver",
        WireReceiver(
            link,
            rates.mpc_period_s,
            stage_times(scenario.mpc, rates.mpc_period_s),
            vehicle,
            poll_period=step,
            poll_offset=3 * step / 8,
        ),
    )
    setpoint_integrator = builder.AddNamedSystem(
        "setpoint_integrator", make_setpoint_integrator(scenario, vehicle)
    )
    supervisor = builder.AddNamedSystem("supervisor", make_supervisor(scenario, vehicle))
    sender = builder.AddNamedSystem("sender", WireSender(link, rates.sensor_period_s, step / 4))

    def connect(source: System, *ports: str) -> None:
        """To all who have inputs of these names."""
        for port in ports:
            for target in (setpoint_integrator, supervisor, sender):
                if target.HasInputPort(port):
                    builder.Connect(source.GetOutputPort(port), target.GetInputPort(port))

    connect(receiver, "u", "status", "reference_verdict", "learner_health")
    connect(supervisor, "mode")
    builder.Connect(setpoint_integrator.GetOutputPort("segment"), sender.GetInputPort("followed"))
    for port in STATION_INTERFACE:
        builder.ExportInput(sender.GetInputPort(port), port)
        if supervisor.HasInputPort(port):
            builder.ConnectInput(port, supervisor.GetInputPort(port))
    for system in (receiver, setpoint_integrator, supervisor):
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
    diagram = builder.Build()
    diagram.set_name("coordinator")
    return diagram

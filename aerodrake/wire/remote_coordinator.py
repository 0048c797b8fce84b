"""Wiring of the station's end, in place of a coordinator in another process.

    event                           period, offset (defaults)     kind
    sender                          10 ms, after 0.25 ms          publish
    receiver                         1 ms, after 0.375 ms         discrete
    receiver, setpoint_integrator   20 ms                         discrete
    supervisor                      10 ms                         discrete

A sample is published after all events of its instant. The reply arrives some milliseconds later,
when the low-level controllers have run already. Each message therefore contains the plan for the
next ticks, which they follow until the reply arrives. This compensates the latency: with 2 to
15 ms the error of the clover's lap is 0.019 mm or less (0.020 mm without a link), and would be
0.031 mm if the setpoints were extrapolated.
"""

from collections.abc import Callable

from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.framework import Diagram, DiagramBuilder

from aerodrake.coordinator import make_coordinator, make_setpoint_integrator, make_supervisor
from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.setpoint.integration import Segment
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import coordinated
from aerodrake.station import STATION_INTERFACE
from aerodrake.wire.link import Link
from aerodrake.wire.message import Layout
from aerodrake.wire.receiver import HORIZONS, WireReceiver
from aerodrake.wire.sender import WireSender
from aerodrake.wiring.table import Wiring

NOT_SENT = ("position_offset",)
"""Signals to the coordinator that are in `followed` already."""

OWN = (
    *("base_setpoint", "joint_setpoint", "u", "mode", "cause", "conditions"),
    *(port for port, _ in HORIZONS.values()),
)
"""Outputs of the coordinator that the station's end computes itself."""

CONNECTIONS = (
    ("receiver", "u", "setpoint_integrator", "u"),
    ("receiver", "status", "supervisor", "status"),
    ("receiver", "reference_verdict", "supervisor", "reference_verdict"),
    ("receiver", "learner_health", "supervisor", "learner_health"),
    ("supervisor", "mode", "setpoint_integrator", "mode"),
    ("setpoint_integrator", "segment", "sender", "followed"),
)
"""Connections of the systems of the station's end: source, output, target, input."""


def make_layouts(coordinator: Diagram, scenario: Scenario) -> tuple[Layout, Layout]:
    """Returns the layouts of the station's and of the coordinator's messages.

    Args:
        coordinator: Coordinator, whose ports define the signals.
        scenario: Scenario of the coordinator. Plan and horizons are sent only as far as the
            supervisor lets the station follow them.

    Raises:
        ScenarioError: if a file that the scenario names cannot be read.
    """
    sections = coordinated(scenario)
    names = (*(name for name in STATION_INTERFACE if name not in NOT_SENT), "followed")
    inputs = [coordinator.GetInputPort(name) for name in names]
    outputs = map(coordinator.get_output_port, range(coordinator.num_output_ports()))
    sizes = {p.get_name(): p.size() for p in outputs if p.get_name() not in OWN}
    ticks, axes = scenario.supervisor.plan_ticks + 2, Segment.axes(sizes["segment"])
    sizes["plan"] = min(sizes["plan"], ticks * axes)
    for name in HORIZONS.keys() & sizes.keys():
        sizes[name] = min(sizes[name], 6 * (ticks + 1))
    return (
        Layout(sections, {port.get_name(): port.size() for port in inputs}),
        Layout(sections, {**sizes, "tick_ms": 1, "output_time_s": 1}),
    )


def make_station_link(
    scenario: Scenario, lcm: DrakeLcmInterface, notify: Callable[[str], None] = lambda note: None
) -> Link:
    """Returns the station's end of the link over `lcm`; `notify` as for `Link`."""
    return Link(lcm, *make_layouts(make_coordinator(scenario), scenario), True, notify)


def make_remote_coordinator(scenario: Scenario, vehicle: VehicleModel, link: Link) -> Diagram:
    """Makes a diagram that receives the coordinator's signals over the link.

    It has a setpoint integrator and a supervisor of its own, since these stay with the vehicle:
    setpoints are continuous whatever is received, and missing messages lead to the safe modes.
    The remote setpoint integrator receives the segment of this one as `followed`.

    Inputs and outputs: those of `make_coordinator` except `followed`, `plan` and the horizons.
    `segment` is that of the station's setpoint integrator.

    Args:
        scenario: Scenario that agrees with the coordinator's in `fingerprint.COORDINATED`.
        vehicle: The scenario's vehicle.
        link: Station's end of the link.
    """
    rates = scenario.rates
    period, step = rates.mpc_period_s, rates.plant_step_s
    stages_s = stage_times(scenario.mpc, period)
    builder = DiagramBuilder()
    systems = {
        "receiver": WireReceiver(link, period, stages_s, vehicle, step, 3 * step / 8),
        "setpoint_integrator": make_setpoint_integrator(scenario, vehicle),
        "supervisor": make_supervisor(scenario, vehicle),
        "sender": WireSender(link, rates.sensor_period_s, step / 4),
    }
    outputs: list[tuple[str, str, str]] = []
    for name, system in systems.items():
        builder.AddNamedSystem(name, system)
        ports = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
        outputs += [(name, port, port) for port in ports]
    inputs = [
        (port, name, port)
        for port in STATION_INTERFACE
        for name in systems
        if systems[name].HasInputPort(port)
    ]
    return Wiring(CONNECTIONS, tuple(inputs), tuple(outputs)).build(builder, "coordinator")

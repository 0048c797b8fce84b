"""System that publishes the station's signals."""

from pydrake.systems.framework import Context, LeafSystem

from aerodrake.support.arguments import Duration, Period, checked
from aerodrake.wire.link import Link


class WireSender(LeafSystem):
    """Publishes its inputs over the link.

    Ports:
        in `state` (13 + 2 n): measured state.
        in `sample_health` (6): s since the last accepted sample of each group, and the verdicts.
        in `joint_oscillation` (n): rad/s, amplitude with which each joint oscillates.
        in `torque_at_limit` (n): 1 for each joint whose torque is at its limit.
        in `external_acceleration` (3): m/s^2 in the world, of the state filter.
        in `specific_thrust` (1): m/s^2, of the flight controller.
        in `disturbance` (6): estimated disturbance, of the flight controller.
        in `saturated` (1): 1 while the flight controller is saturated.
        in `rotor_effectiveness` (k): fraction of its thrust that each rotor gives.
        in `followed` (3 (3 + n) + 1): the `Segment` that the setpoint integrator follows.
        They are the signals of the link's outgoing messages.
    State:
        none.
    Rate:
        publishes at each `period`, after `offset`; the time of the message is without `offset`.

    Args:
        link: Station's end of the link.
        period: s.
        offset: s.
    """

    @checked
    def __init__(self, link: Link, period: Period, offset: Duration):
        super().__init__()
        self._link, self._offset = link, offset
        sizes = link.outgoing.sizes
        self._ports = {name: self.DeclareVectorInputPort(name, sizes[name]) for name in sizes}
        self.DeclarePeriodicPublishEvent(period, offset, self._publish)

    def _publish(self, context: Context) -> None:
        signals = {name: port.Eval(context) for name, port in self._ports.items()}
        self._link.publish(context.get_time() - self._offset, signals)

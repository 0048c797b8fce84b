"""System that publishes the station's signals."""

from pydrake.systems.framework import Context, LeafSystem

from aerodrake.wire.link import Link


class WireSender(LeafSystem):
    """Publishes its inputs over the link.

    Ports:
        in: the signals of the link's outgoing messages, by name.
    State:
        none.
    Rate:
        publishes at each `period`, after `offset`; the time of the message is without `offset`.

    Args:
        link: Station's end of the link.
        period: s.
        offset: s.
    """

    def __init__(self, link: Link, period: float, offset: float):
        super().__init__()
        self._link, self._offset = link, offset
        sizes = link.outgoing.sizes
        self._ports = {name: self.DeclareVectorInputPort(name, sizes[name]) for name in sizes}
        self.DeclarePeriodicPublishEvent(period, offset, self._publish)

    def _publish(self, context: Context) -> None:
        signals = {name: port.Eval(context) for name, port in self._ports.items()}
        self._link.publish(context.get_time() - self._offset, signals)

"""From a station's signals to messages for the coordinator."""

from __future__ import annotations

from pydrake.systems.framework import Context, LeafSystem

from aerodrake.wire.link import Link


class WireSender(LeafSystem):
    """Tells the other end what stands at its inputs.

    Ports:
        in: the parts of the link's messages, by name.
    State, rate:
        none; a message each `period`, after `offset`. Its time is the multiple of `period`.

    Args:
        link: This end of the wire.
        period: s.
        offset: s.
    """

    def __init__(self, link: Link, period: float, offset: float):
        super().__init__()
        self._link, self._offset = link, offset
        self._parts = {
            name: self.DeclareVectorInputPort(name, size) for name, size in link.tells.sizes.items()
        }
        self.DeclarePeriodicPublishEvent(period, offset, self._send)

    def _send(self, context: Context) -> None:
        parts = {name: port.Eval(context) for name, port in self._parts.items()}
        self._link.tell(context.get_time() - self._offset, parts)

"""LCM interface of one end of the link."""

import ipaddress
import re
import socket

from pydrake.lcm import DrakeLcm

from aerodrake.support.errors import BadInput

LOOPBACK_S = 1.0
"""s, longest wait for a message to this machine itself."""

REMEDY = "for one machine alone: ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo"
"""Commands that make a network of one machine."""


def make_lcm(url: str) -> DrakeLcm:
    """Returns an LCM interface for a URL in LCM's form, udpm://ADDRESS:PORT?ttl=N.

    Raises:
        BadInput: if the URL is invalid, or if this machine cannot exchange multicast messages at
            its address. LCM itself would continue without a network.
    """
    match = re.fullmatch(r"udpm://([0-9.]+):([0-9]{1,5})(?:\?ttl=([0-9]{1,3}))?", url)
    try:
        address, port, ttl = match.groups(default="0")
        is_valid = ipaddress.IPv4Address(address).is_multicast
        is_valid = is_valid and 0 < int(port) < 65536 and int(ttl) < 256
    except (AttributeError, ValueError):
        is_valid = False
    if not is_valid:
        problem = f"expected udpm://ADDRESS:PORT?ttl=N with a multicast address, got {url!r}"
        raise BadInput("lcm", "", problem)
    _check_port(int(port))
    _check_route(address)
    return DrakeLcm(url)


def _check_port(port: int) -> None:
    """Raises BadInput if LCM could not receive at the port, which several processes may share."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            receiver.bind(("", port))
        except OSError as error:
            expected = "expected a UDP port that this process may share with others"
            raise BadInput("lcm", "", f"{expected}, got {port}: {error.strerror}") from None


def _check_route(address: str) -> None:
    """Raises BadInput if a message to a multicast address does not arrive at this machine itself.

    Its port is one that no other process uses.
    """
    udp = socket.AF_INET, socket.SOCK_DGRAM
    with socket.socket(*udp) as receiver, socket.socket(*udp) as sender:
        receiver.settimeout(LOOPBACK_S)
        try:
            receiver.bind(("", 0))
            sender.connect((address, receiver.getsockname()[1]))  # Looks the route up.
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # Stays here.
            group = socket.inet_aton(address) + socket.inet_aton("0.0.0.0")
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
            sender.send(b"")
            receiver.recv(1)
        except OSError as error:
            reason = error.strerror or "a message to this machine itself does not arrive"
            expected = f"expected a network with a multicast route to {address}, got: {reason}"
            raise BadInput("lcm", "", f"{expected} ({REMEDY})") from None

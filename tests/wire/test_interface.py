"""LCM interfaces on machines with and without a network for multicast."""

import errno
import json
import shutil
import socket
import subprocess
import sys

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.wire import interface
from aerodrake.wire.interface import make_lcm

URL = "udpm://239.255.76.67:7668?ttl=0"


@pytest.mark.parametrize(
    "url",
    [
        *("", "nonsense", "memq://", "udpm://", "udpm://239.255.76.67", "udp://239.255.76.67:7667"),
        *("udpm://10.0.0.1:7667", "udpm://239.255.76.300:7667", "udpm://239.255.76.67:0"),
        *("udpm://239.255.76.67:70000", "udpm://239.255.76.67:7667?ttl=256"),
        *("udpm://239.255.76.67:7667?ttl=", "udpm://239.255.76.67:7667?tll=1"),
    ],
)
def test_an_invalid_address_is_refused(url):
    with pytest.raises(BadInput, match="^lcm: expected udpm://"):
        make_lcm(url)


def test_a_valid_address_is_used():
    url = "udpm://239.255.76.67:7668?ttl=0"
    assert make_lcm(url).get_lcm_url() == url


def test_a_port_of_another_program_is_refused():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("", 0))
        port = other.getsockname()[1]
        with pytest.raises(BadInput, match=f"^lcm: .* got {port}: Address already in use$"):
            make_lcm(f"udpm://239.255.76.67:{port}?ttl=0")


@pytest.mark.parametrize("code", [errno.EACCES, errno.EPERM])
def test_a_port_that_is_not_permitted_is_refused(monkeypatch, code):
    def bind(receiver, address):
        raise OSError(code, "Not permitted")

    monkeypatch.setattr(socket.socket, "bind", bind)
    with pytest.raises(BadInput, match="^lcm: .* got 7668: Not permitted$"):
        make_lcm(URL)


def test_a_message_that_does_not_arrive_is_a_fault_of_the_network(monkeypatch):
    """As behind a firewall."""
    monkeypatch.setattr(interface, "LOOPBACK_S", 0.05)
    monkeypatch.setattr(socket.socket, "send", lambda sender, data: None)
    with pytest.raises(BadInput, match="a message to this machine itself does not arrive"):
        make_lcm(URL)


COMMANDS = """
import json, subprocess, sys
from aerodrake.cli import main
from aerodrake.support.errors import BadInput
from aerodrake.wire.interface import make_lcm

def outcome():
    try:
        return make_lcm(sys.argv[1]).get_lcm_url()
    except BadInput as error:
        return str(error)

options = ["hover", "--quiet", "--lcm", sys.argv[1]]
codes = [main(["run", *options]), main(["coordinator", *options])]
outcomes = []
for setup in ("link set lo up", "route add prohibit 224.0.0.0/4", "route del 224.0.0.0/4",
              "route add 224.0.0.0/4 dev lo"):
    subprocess.run(["ip", *setup.split()], check=True)
    outcomes.append(outcome())
print(json.dumps([codes, outcomes]))
"""


def test_without_a_multicast_route_commands_end_with_one_line(tmp_path):
    """In a network namespace of its own, which is created with a down loopback device alone."""
    namespace = ["unshare", "--map-root-user", "--net"]
    if not (shutil.which("unshare") and shutil.which("ip")):
        pytest.skip("needs unshare of util-linux and ip of iproute2")
    refusal = subprocess.run([*namespace, "true"], capture_output=True, text=True)
    if refusal.returncode:
        pytest.skip(f"network namespaces are not available: {refusal.stderr.strip()}")
    command = [*namespace, sys.executable, "-c", COMMANDS, URL]
    process = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120)
    codes, outcomes = json.loads(process.stdout)
    assert codes == [2, 2]
    run, coordinator = process.stderr.splitlines()
    expected = "expected a network with a multicast route to 239.255.76.67, got:"
    assert run == coordinator
    assert run.startswith(
        f"aerodrake: --lcm: {expected} Network is unreachable (for one machine alone: "
    )
    without_route, prohibited, deleted, with_route = outcomes
    assert f"{expected} Network is unreachable" in without_route
    assert f"{expected} Permission denied" in prohibited and deleted == without_route
    assert with_route == URL
    assert not list(tmp_path.iterdir())

"""The server of a scene ends with its `with` statement."""

import socket

from aerodrake.reports.scene import Scene


def test_its_server_is_gone(scenario, vehicle):
    with Scene(scenario, vehicle) as scene:
        port = scene.meshcat.port()
        with socket.create_connection(("localhost", port)):
            pass
    with socket.socket() as client:
        assert client.connect_ex(("localhost", port)) != 0

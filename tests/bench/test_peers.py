"""Each peer solves sequences of programs to the exact minimiser."""

from importlib.util import find_spec

import numpy as np
import pytest

from aerodrake.bench.exact import exact_minimiser
from aerodrake.bench.peers import PEERS

NZ, ROWS = 12, 20


def random_programs(seed: int, count: int):
    """Returns A and a sequence of feasible programs with some redundant constraints."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(ROWS, NZ))
    A /= np.linalg.norm(A, axis=1)[:, None]
    F = rng.normal(size=(NZ, NZ))
    inside = A @ rng.uniform(-0.5, 0.5, NZ)
    programs = []
    for step in range(count):
        H = (40 + step) * (F.T @ F + 0.1 * np.eye(NZ))
        g = -H @ rng.uniform(-1.5, 1.5, NZ)
        lower, upper = inside - rng.uniform(0.01, 4, ROWS), inside + rng.uniform(0.01, 4, ROWS)
        programs.append((H, g, lower, upper))
    return A, programs


@pytest.mark.parametrize("name", PEERS)
@pytest.mark.parametrize("seed", range(3))
def test_a_peer_solves_a_sequence_of_programs(name, seed):
    kind = PEERS[name]
    if find_spec(kind.package) is None:
        pytest.skip(f"{kind.package} is not installed")
    A, programs = random_programs(seed, 6)
    peer = kind(A)
    for program in programs:
        z = peer.solve(*(part.copy() for part in program))
        optimum = exact_minimiser(*program, A)
        np.testing.assert_allclose(z, optimum.z, atol=2e-4)


def test_peers_describe_their_package_and_settings():
    for kind in PEERS.values():
        assert kind.package and kind.settings and kind.__doc__

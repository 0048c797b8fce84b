"""Recorded ticks are those of the flight, and a replay answers as the flight did."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.bench.peers import Peer
from aerodrake.bench.solvers import judge
from aerodrake.bench.ticks import OWN, record_ticks, replay
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.qp.condensed_qp import QpStatus
from aerodrake.scenario import MovingTarget, Scenario

INPUTS = 9


class Never(Peer):
    """Says what is out of reach, and spoils what it was given."""

    package, settings = "numpy", "none"
    seen: list[np.ndarray] = []

    def _set_up(self) -> None:
        self.calls = 0

    def solve(self, H, g, lower, upper):
        Never.seen.append(H.copy())
        z = 7 + g
        H[:], g[:], lower[:], upper[:] = np.nan, np.nan, np.nan, np.nan
        return z


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """A target that is far at first, so that bounds are active; measured with noise."""
    noisy = replace(Scenario().sensors, position_noise_m=1e-3)
    return Scenario(name="far", duration=0.4, settle_s=0.1, reference=MovingTarget(), sensors=noisy)


@pytest.fixture(scope="module")
def recorded(scenario):
    return record_ticks(scenario)


def test_a_replay_commands_what_was_flown(scenario, recorded):
    """Noise and all: what is recorded is what each update saw, no sample sooner or later."""
    log = FlightSimulation(scenario).fly()
    ticks = len(recorded.inputs)
    assert ticks == len(log["tick_ms"]) == 25
    stride = 2
    flown = np.hstack([log["a_Bd_m_s2"], log["qddot_d_rad_s2"]])[stride::stride]
    measured = replay(recorded, {}, passes=1)
    # The setpoint integrator keeps the limits; until these are met, it commands what it is told.
    np.testing.assert_allclose(measured.u_0[OWN][: len(flown)], flown, atol=1e-6)
    statuses = log["qp_status"][stride::stride]
    assert [int(s) for s in measured.statuses[: len(statuses)]] == list(statuses)


def test_peers_get_the_same_programs_and_do_not_spoil_each_others(recorded):
    Never.seen.clear()
    measured = replay(recorded, {"one": Never, "two": Never}, passes=2)
    alone = replay(recorded, {}, passes=1)
    np.testing.assert_array_equal(measured.u_0[OWN], alone.u_0[OWN])
    assert measured.statuses == alone.statuses
    assert all(np.isfinite(H).all() for H in Never.seen)
    for name in ("one", "two", OWN):
        assert measured.u_0[name].shape == (25, INPUTS)
        assert (measured.solving_ms[name] > 0).all()
        assert (measured.tick_ms(name) > measured.forming_ms[name]).all()


def test_verdicts(recorded):
    """The solver that flies is right, the one that is not is told so, in units of the inputs."""
    measured = replay(recorded, {"never": Never}, passes=1)
    verdict = judge(recorded, measured)
    assert verdict.residual < 1e-9
    assert verdict.u0_error[OWN].max() < 1e-3
    assert verdict.u0_error["never"].min() > 1
    shortcut = np.array([s is QpStatus.UNCONSTRAINED for s in measured.statuses])
    np.testing.assert_array_equal(verdict.is_bounded, ~shortcut)
    assert 0 < verdict.is_bounded.sum() < len(shortcut)

"""Recorded ticks are those of the flight, and a replay solves them as the flight did."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.bench import ticks
from aerodrake.bench.peers import Peer
from aerodrake.bench.solvers import evaluate
from aerodrake.bench.ticks import OWN, record_ticks, replay
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.qp.result import QpStatus
from aerodrake.scenario import MovingTarget, Scenario

INPUTS = 9


class Never(Peer):
    """Returns infeasible solutions and overwrites its arguments."""

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
    """A distant target, so that constraints are active; measured with noise."""
    noisy = replace(Scenario().sensors, position_noise_m=1e-3)
    return Scenario(name="far", duration=0.4, settle_s=0.1, reference=MovingTarget(), sensors=noisy)


@pytest.fixture(scope="module")
def recorded(scenario):
    return record_ticks(scenario)


def test_a_replay_equals_the_flight(scenario, recorded):
    """Including noise: the recorded inputs are those of each update."""
    log = FlightSimulation(scenario).fly()
    ticks = len(recorded.inputs)
    assert ticks == len(log["tick_ms"]) == 25
    stride = 2
    flown = np.hstack([log["a_Bd_m_s2"], log["qddot_d_rad_s2"]])[stride::stride]
    measured = replay(recorded, {}, passes=1)
    # Equal as long as the setpoint integrator does not apply its limits.
    np.testing.assert_allclose(measured.u_0[OWN][: len(flown)], flown, atol=1e-6)
    statuses = log["qp_status"][stride::stride]
    assert [int(s) for s in measured.statuses[OWN][: len(statuses)]] == list(statuses)


def test_peers_get_the_same_programs_and_cannot_change_them(recorded):
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


def test_slow_solvers_take_part_in_the_first_pass_only(recorded, monkeypatch):
    monkeypatch.setattr(ticks, "SLOW_MS", 0.0)
    Never.seen.clear()
    measured = replay(recorded, {"never": Never}, 2, {"osqp": {"shortcut": False}})
    assert len(Never.seen) == 25 + ticks.UNMEASURED
    assert len(measured.statuses[OWN]) == len(measured.statuses["osqp"]) == 25


def test_errors_are_those_against_the_exact_minimiser(recorded):
    """Small for the MPC's solver, large for a wrong one, in units of the inputs."""
    measured = replay(recorded, {"never": Never}, passes=1)
    evaluation = evaluate(recorded, measured)
    assert evaluation.residual < 1e-9
    assert evaluation.u0_error[OWN].max() < 1e-3
    assert evaluation.u0_error["never"].min() > 1
    is_unconstrained = np.array([s is QpStatus.UNCONSTRAINED for s in measured.statuses[OWN]])
    np.testing.assert_array_equal(evaluation.is_constrained, ~is_unconstrained)
    assert 0 < evaluation.is_constrained.sum() < len(is_unconstrained)

"""Scaling of the MPC tick with the horizon and the number of joints."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.bench.arms import with_joints
from aerodrake.bench.peers import PEERS
from aerodrake.bench.solvers import installed_peers, spread
from aerodrake.bench.ticks import OWN, record_ticks, replay
from aerodrake.flight.summary import rounded
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_scenario

SCENARIO = "clover"
HORIZONS = (5, 10, 15, 20, 30, 40, 60)
FITTED_FROM = 15
"""Shortest horizon in the fit of the exponent."""
JOINTS = tuple(range(3, 10))
PEER = "daqp"
"""Solver that also solves the ticks, if it is installed; it evicts caches as a flight does."""


def scaling_figures(flown_s: float, passes: int, progress: Callable[[str], None]) -> dict[str, Any]:
    """Flies clovers with other horizons and arms, and replays their ticks.

    A horizon of N stages lasts N / N_0 times as long as that of the scenario with N_0 stages.

    Keys:
        horizon: For each N the stages, their duration in ticks, and the tick times of the
            MPC and the peer.
        horizon_exponent: p of the fit time ~ N^p to the medians from N = 15 on.
        joints: For each number of joints the tick times.

    Args:
        flown_s: Reference time of each flight, without hover before.
        passes: Number of passes through the ticks.
        progress: Called with the name of each step at its start.
    """
    scenario = replace(load_scenario(SCENARIO), duration=flown_s, settle_s=0.0)
    progress("horizons")
    own, horizons = scenario.mpc, []
    for N in HORIZONS:
        span = round(own.span_ticks * N / own.horizon)
        longer = replace(scenario, mpc=replace(own, horizon=N, span_ticks=span))
        horizons.append({"N": N, "span_ticks": span, **_times(longer, passes)})
    fitted = [row for row in horizons if row["N"] >= FITTED_FROM]
    exponent, _ = np.polyfit(
        np.log([row["N"] for row in fitted]), np.log([row["median_ms"] for row in fitted]), 1
    )
    progress("joints")
    joints = []
    with tempfile.TemporaryDirectory() as folder:
        for n in JOINTS:
            robot = Path(folder, f"arm{n}.urdf")
            joints.append({"joints": n, **_times(with_joints(scenario, n, robot), passes)})
    return {"horizon": horizons, "horizon_exponent": rounded(float(exponent)), "joints": joints}


def _times(scenario: Scenario, passes: int) -> dict[str, Any]:
    peers = {PEER: PEERS[PEER]} if PEER in installed_peers() else {}
    measured = replay(record_ticks(scenario), peers, passes)
    return {
        **spread(measured.tick_ms(OWN)),
        "forming_median_ms": rounded(np.median(measured.forming_ms[OWN])),
        "peers_median_ms": {name: rounded(np.median(measured.tick_ms(name))) for name in peers},
    }

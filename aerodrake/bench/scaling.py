"""How the MPC's tick grows with the horizon and with the joints of the arm."""

from __future__ import annotations

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
"""The exponent is that of the horizons from here on."""
JOINTS = tuple(range(3, 10))
PEER = "daqp"
"""Solves the same ticks where it is installed, and clears the caches as a flight would."""


def scaling_figures(flown_s: float, passes: int, progress: Callable[[str], None]) -> dict[str, Any]:
    """Flies clovers of other horizons and arms, and replays their ticks.

    The stages keep their shape: a horizon of N stages lasts N / N_0 times the
    scenario's own.

    Keys:
        horizon: for each N its stages, the ticks they last, and the tick's times, and the peer's.
        horizon_exponent: p of the fit time ~ N^p to the medians from N = 15 on.
        joints: for each number of joints the tick's times.

    Args:
        flown_s: Reference time of each flight; nothing is flown before.
        passes: Through its ticks.
        progress: Called with each step's name as it begins.
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

"""Random flights with faults, drawn from a seed, flown by the command line, and checked.

    python -m tests.campaign --flights 500 --seed 0

draws a scenario for each flight: a reference, possibly sensor noise and delay, wind, payload
and model mismatch, and one to four faults of any kind, time and duration. It prints the
problems of each flight, and how many flights ended with which exit reason.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from aerodrake.scenario.load import packaged_scenarios

SETTLE_S, DURATION_S = 1.0, 8.0
ENDINGS = {"completed", "hold", "descend", "landed", "stopped", "lost"}
"""Exit reasons of flights that are not interrupted."""

TIMEOUT_S = 300.0
"""Wall time after which a flight counts as hanging."""

REFERENCES: tuple[dict[str, Any], ...] = (
    {"kind": "hover"},
    {"kind": "clover", "amplitude_m": 0.5, "lap_s": 24.0, "start_s": 2.0},
    {"kind": "figure_eight", "length_m": 0.8, "width_m": 0.4, "lap_s": 12.0},
    {"kind": "lissajous"},
    {"kind": "moving_target"},
)
SENSORS = {
    "position_noise_m": 0.002,
    "velocity_noise_m_s": 0.02,
    "attitude_noise_rad": 0.0035,
    "rate_noise_rad_s": 0.01,
    "joint_noise_rad": 0.0009,
}
LEARNING = "clover_position"
"""Packaged scenario with online learning, for learning faults."""


def draw(seed: int) -> dict[str, Any]:
    """Returns the scenario of one flight as a YAML mapping."""
    rng = np.random.default_rng(seed)
    scenario: dict[str, Any] = {
        "name": f"campaign-{seed}",
        "seed": seed,
        "duration": DURATION_S,
        "settle_s": SETTLE_S,
        "reference": REFERENCES[rng.integers(len(REFERENCES))],
    }
    if rng.random() < 0.5:
        scenario["sensors"] = SENSORS | {"base_delay_s": 0.01}
        scenario["filter"] = {"delay_s": 0.01, "velocity_noise_m_s": 0.02}
    if rng.random() < 0.3:
        scenario["wind"] = {"velocity_m_s": [1.0, 0.5, 0.0], "gust_m_s": [1.0, 1.0, 0.3]}
    if rng.random() < 0.3:
        scenario["payload"] = {"mass_kg": round(rng.uniform(0.05, 0.3), 3)}
    if rng.random() < 0.3:
        scenario["mismatch"] = {"mass_scale": 1.05, "rotor_lag_scale": 1.2}
    count = 1 if rng.random() < 0.6 else int(rng.integers(2, 5))
    scenario["faults"] = [draw_fault(rng) for _ in range(count)]
    if any(fault["kind"].startswith("learner") for fault in scenario["faults"]):
        learning = yaml.safe_load(packaged_scenarios()[LEARNING].read_text())
        own = ("name", "seed", "duration", "settle_s", "faults")  # Its gains do not tolerate noise.
        scenario = learning | {key: scenario[key] for key in own}
    return scenario


def draw_fault(rng: np.random.Generator) -> dict[str, Any]:
    """Returns one fault as a YAML mapping; most are short, a few last until the end."""

    def uniform(low: float, high: float) -> float:
        return round(rng.uniform(low, high), 4)

    def vector(size: float) -> list[float]:
        return [uniform(-size, size) for _ in range(3)]

    def any_of(*options: Any) -> Any:
        return options[rng.integers(len(options))]

    group = {"group": any_of("all", "position", "attitude", "joints")}
    size = 10 ** uniform(-2, 1)
    kinds: dict[str, dict[str, Any]] = {
        "sample_nan": group,
        "sample_stale": group,
        "sample_frozen": group,
        "sample_jump": group
        | {"position_m": round(size, 4), "angle_rad": round(min(size, 3.0), 4)},
        "rotor_degraded": {
            "rotor": int(rng.integers(4)),
            "remaining": any_of(0.0, 0.8, 0.9, uniform(0, 1)),
        },
        "joint_degraded": {"joint": int(rng.integers(6)), "remaining": uniform(0, 1)},
        "push": {"force_n": vector(15)},
        "mpc_infeasible": {},
        "mpc_starved": {"iterations": int(rng.integers(1, 60))},
        "mpc_non_finite": {},
        "mpc_missed": {},
        "learner_nan": {},
        "learner_diverged": {"theta_m_s": round(10 ** uniform(-2, 5), 4)},
        "learner_poisoned": {"velocity_m_s": vector(1)},
        "reference_jump": {"offset_m": vector(any_of(0.5, 2.0, 100.0))},
        "reference_drift": {"velocity_m_s": vector(any_of(0.5, 3.0, 50.0))},
        "reference_nan": {},
    }
    kind = any_of(*kinds)
    lasting = any_of(30.0, *([round(10 ** uniform(-1.7, 0.7), 3)] * 5))
    return {"kind": kind, "start_s": uniform(-0.5, 6.0), "duration_s": lasting, **kinds[kind]}


def must_complete(scenario: dict[str, Any]) -> bool:
    """Returns True if the flight must complete, by the tables in `diagrams/faults.md`."""
    if len(scenario["faults"]) > 1:
        return False
    (fault,) = scenario["faults"]
    kind, lasts = fault["kind"], fault["duration_s"]
    # A flight that ends in HOLD is not completed.
    is_over = fault["start_s"] + lasts < DURATION_S - 1.0
    if kind.startswith("sample"):
        most = {"position": 1.0, "attitude": 0.3, "joints": 0.5, "all": 0.3}[fault["group"]]
        return lasts <= most and is_over
    if kind == "rotor_degraded":
        return fault["remaining"] >= 0.8
    if kind == "joint_degraded":
        return fault["remaining"] >= 0.5
    if kind == "push":
        return lasts <= 1.0 and math.hypot(*fault["force_n"]) <= 10.0
    if kind.startswith("mpc"):
        return lasts <= 4.0 and is_over
    if kind.startswith("learner"):
        return True
    return kind == "reference_nan" and is_over or kind == "reference_jump" and _is_near(fault)


def _is_near(fault: dict[str, Any]) -> bool:
    return math.hypot(*fault["offset_m"]) <= 0.5


@dataclass(frozen=True)
class FlightResult:
    """Result of one flight.

    Attributes:
        seed: Seed of its scenario.
        ending: Exit reason; empty if there is none.
        problems: Problems of the flight; empty if there are none.
    """

    seed: int
    ending: str
    problems: str


def in_a_process(arguments: list[str]) -> tuple[int, str]:
    """Returns the exit code and the stderr of `aerodrake`."""
    command = [sys.executable, "-m", "aerodrake", *arguments]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    return ran.returncode, ran.stderr


def check_flight(
    seed: int, folder: Path, run: Callable[[list[str]], tuple[int, str]] = in_a_process
) -> FlightResult:
    """Flies one scenario by the command line in `folder`, and checks all of its files."""
    scenario = draw(seed)
    path, out = folder / f"{seed}.yaml", folder / f"{seed}"
    path.write_text(yaml.safe_dump(scenario, sort_keys=False))
    try:
        code, stderr = run(["run", str(path), "--out", str(out), "--quiet"])
    except subprocess.TimeoutExpired:
        return FlightResult(seed, "", "hangs")
    if code not in (0, 1) or stderr:
        return FlightResult(seed, "", f"exit code {code}: {stderr.strip()[-500:]}")
    text = (out / "summary.json").read_text()
    summary = json.loads(text, parse_constant=lambda name: name)
    ending = summary["exit_reason"]
    problems = []
    if "NaN" in text or "Infinity" in text:
        problems.append("summary.json contains NaN or infinite")
    with np.load(out / "log.npz", allow_pickle=False) as log:
        not_finite = [
            key for key in log if log[key].dtype.kind == "f" and not np.isfinite(log[key]).all()
        ]
    if not_finite:
        problems.append(f"log.npz contains NaN or infinite: {', '.join(not_finite)}")
    if ending not in ENDINGS:
        problems.append(f"unknown exit reason: {ending}")
    if (code == 0) != (ending == "completed"):
        problems.append(f"exit code {code} of a flight that ends as {ending}")
    if must_complete(scenario) and ending != "completed":
        problems.append(f"expected to complete, but {ending}: {summary['exit_cause']}")
    return FlightResult(seed, ending, "; ".join(problems))


def campaign(seeds: range, jobs: int, folder: Path) -> list[FlightResult]:
    """Returns the results of all flights, and prints those with problems as they end."""
    results = []
    with ThreadPoolExecutor(jobs) as pool:
        for result in pool.map(lambda seed: check_flight(seed, folder), seeds):
            results.append(result)
            if result.problems:
                print(f"seed {result.seed}: {result.problems}\n    {draw(result.seed)['faults']}")
    return results


def main() -> int:
    """Flies a campaign; returns 1 if a flight has problems."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--flights", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="of the first flight")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        seeds = range(arguments.seed, arguments.seed + arguments.flights)
        results = campaign(seeds, arguments.jobs, Path(folder))
    endings = Counter(result.ending for result in results)
    with_problems = sum(bool(result.problems) for result in results)
    ended = ", ".join(f"{count} {ending}" for ending, count in endings.most_common())
    print(f"{len(results)} flights, {with_problems} with problems: {ended}")
    return 1 if with_problems else 0


if __name__ == "__main__":
    sys.exit(main())

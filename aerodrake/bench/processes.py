"""Start-up time and memory of whole commands, each in a separate process."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerodrake.flight.summary import rounded

LAUNCHER = """
import json, os, resource, subprocess, sys, time
start = time.perf_counter()
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
wall = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps([code, wall, peak * (1 if sys.platform == "darwin" else 1024)]))
"""
"""Runs a command and prints [exit code, wall time in s, peak resident memory in bytes].

It is a small separate process, since a command inherits the peak memory of its parent.
"""


@dataclass(frozen=True)
class ProcessCost:
    """Cost of one command.

    Attributes:
        wall_s: Wall time.
        peak_rss_mb: Peak resident memory in 1e6 bytes.
    """

    wall_s: float
    peak_rss_mb: float


def run_command(*arguments: str) -> ProcessCost:
    """Runs `aerodrake ARGUMENTS` in a separate process.

    Raises:
        RuntimeError: if the command fails.
    """
    command = [sys.executable, "-m", "aerodrake", *arguments]
    launcher = [sys.executable, "-c", LAUNCHER, *command]
    done = subprocess.run(launcher, capture_output=True, text=True, check=True)
    code, wall_s, peak = json.loads(done.stdout)
    if code != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {code}: {done.stderr.strip()}")
    return ProcessCost(wall_s, peak / 1e6)


def process_figures(
    clover_s: float, hover_s: float, repeats: int, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Measures commands of the command line.

    Keys:
        startup: Least wall time in s of `--help` and of `run hover --duration 1`.
        peak_rss_mb: Peak memory of `run clover`, with all outputs.
        rss_growth_mb: Difference of the peak memory of a long hover and one of 1 s.
        memory: Durations and peaks behind these numbers.

    Args:
        clover_s, hover_s: Reference time of the clover and of the long hover.
        repeats: Number of starts.
        progress: Called with the name of each step at its start.
    """

    def flown(scenario: str, duration_s: float) -> ProcessCost:
        with tempfile.TemporaryDirectory() as folder:
            options = ("--quiet", "--out", str(Path(folder, "run")))
            return run_command("run", scenario, *options, "--duration", str(duration_s))

    progress("start-up")
    helps = [run_command("--help") for _ in range(repeats)]
    shorts = [flown("hover", 1.0) for _ in range(repeats)]
    progress(f"memory of {clover_s:g} s of clover")
    clover = flown("clover", clover_s)
    progress(f"memory of {hover_s:g} s of hover")
    short_mb, long_mb = shorts[-1].peak_rss_mb, flown("hover", hover_s).peak_rss_mb
    return {
        "startup": {
            "help_s": rounded(min(cost.wall_s for cost in helps)),
            "hover_s": rounded(min(cost.wall_s for cost in shorts)),
        },
        "peak_rss_mb": rounded(clover.peak_rss_mb),
        "rss_growth_mb": rounded(long_mb - short_mb),
        "memory": {
            "clover_s": clover_s,
            "hover_s": hover_s,
            "short_hover_mb": rounded(short_mb),
            "long_hover_mb": rounded(long_mb),
        },
    }

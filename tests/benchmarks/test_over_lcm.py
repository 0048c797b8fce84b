"""Station and coordinator as two processes in real time; requires an idle machine.

pytest tests/benchmarks/test_over_lcm.py -s
"""

import json
import subprocess
import sys

import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.scenario.load import load_scenario

URL = "udpm://239.255.76.67:7767?ttl=0"


@pytest.mark.parametrize("name", ["clover", "clover_paper", "moving_target"])
def test_real_time_does_not_reduce_accuracy(name, tmp_path, capsys):
    scenario = load_scenario(name)
    key = "settled_mean_m" if name == "moving_target" else "lap_mean_m"
    here = summarize(scenario, FlightSimulation(scenario).fly())["error"][key]
    aerodrake = (sys.executable, "-m", "aerodrake")
    options = (name, "--lcm", URL)
    coordinator = subprocess.Popen(
        [*aerodrake, "coordinator", *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    station = subprocess.run([*aerodrake, "run", *options, "--quiet", "--out", tmp_path / "out"])
    report, _ = coordinator.communicate()
    assert (station.returncode, coordinator.returncode) == (0, 0)
    figures = json.loads((tmp_path / "out" / "summary.json").read_text())
    mpc, over = figures["mpc"], figures["error"][key]
    with capsys.disabled():
        print(f"\n{name}: {1e3 * here:.4f} mm here, {1e3 * over:.4f} mm over LCM, ", end="")
        print(f"{mpc['missed']} of {mpc['ticks'] + mpc['missed']} ticks missed")
        print(report.decode().splitlines()[-1])
    assert over <= 1.2 * here
    assert mpc["missed"] < 0.01 * (mpc["ticks"] + mpc["missed"])
    assert figures["real_time_factor"] == pytest.approx(1.0, abs=0.01)

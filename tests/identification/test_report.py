"""Table, figure and files of an identification."""

import json
from importlib.metadata import version

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.identification.identify import ARMS, AXES, Identification, Record, identify_axis
from aerodrake.identification.report import (
    FIGURE,
    RESULTS,
    draw,
    plot_identification,
    table,
    write_results,
)
from aerodrake.scenario import Flight, Model, Scenario
from aerodrake.scenario.load import load_scenario


def record(k: float, seed: int) -> Record:
    """Returns samples of a base with lag 1 / k that follows a sine, with noise of 1 mm/s."""
    t = 0.02 * np.arange(1000)
    noise = 1e-3 * np.random.default_rng(seed).normal(size=len(t))
    error = 0.1 * np.cos(t)
    return Record(t, 0.1 * k * np.sin(t) + error, 0.1 * k * np.sin(t), k * error + noise)


@pytest.fixture(scope="module")
def identification() -> Identification:
    scenario = Scenario(
        name="cost $x^$ and a_b",
        seed=4,
        flight=Flight(interface="position", position_gain=(25, 25, 16), velocity_gain=(10, 10, 8)),
        model=Model(kind="paper", k_b=(2.5, 2.5, 2.25)),
    )
    axes = {
        name: identify_axis(scenario, {arm: record(k, i) for i, arm in enumerate(ARMS)})
        for name, k in zip(AXES, (1.2344, 2.0, 0.9884), strict=True)
    }
    return Identification(scenario, axes)


def test_rows_have_k_b_its_interval_and_other_values(identification):
    lines = table(identification).splitlines()
    assert lines[0].startswith("cost $x^$ and a_b: ") and "flight.interface position" in lines[0]
    rows = {line[0]: line.split() for line in lines if line[:2] in ("x ", "y ", "z ")}
    for (name, axis), own, paper in zip(
        identification.axes.items(), ("2.50", "2.50", "2.25"), ("6.67", "6.67", "2.38"), strict=True
    ):
        low, high = axis.fit.interval
        assert rows[name] == [
            name, f"{axis.fit.gain:.3f}", f"{low:.3f}", "..", f"{high:.3f}", f"{axis.fit.r2:.3f}",
            f"{axis.gains['still']:.3f}", f"{axis.gains['moving']:.3f}", own, paper,
        ]  # fmt: skip
        assert low < axis.fit.gain < high


@pytest.fixture(scope="module")
def folder(identification, tmp_path_factory):
    folder = tmp_path_factory.mktemp("identification")
    write_results(identification, "aerodrake identify it", folder)
    draw(identification, folder)
    return folder


def test_files(identification, folder):
    assert sorted(path.name for path in folder.iterdir()) == sorted((*RESULTS, FIGURE))
    figures = json.loads((folder / "identification.json").read_text())
    assert figures["command"] == "aerodrake identify it"
    assert (figures["scenario"], figures["seed"]) == ("cost $x^$ and a_b", 4)
    assert figures["version"] == version("aerodrake")
    assert figures["interface"] == "position" and figures["level"] == 0.95
    assert figures["position_gain"] == [25, 25, 16] and figures["velocity_gain"] == [10, 10, 8]
    assert figures["k_b"] == [1.23, 2.0, 0.988]
    assert figures["scenario_k_b"] == [2.5, 2.5, 2.25]
    assert figures["paper_k_b"] == [6.67, 6.67, 2.38]
    for name, axis in identification.axes.items():
        row = figures["axes"][name]
        assert row["k_b"] == pytest.approx(axis.fit.gain, rel=1e-11)
        assert row["interval"] == pytest.approx(axis.fit.interval, rel=1e-11)
        assert row["r2"] == pytest.approx(axis.fit.r2, rel=1e-11)
        assert row["k_b_by_arm"] == pytest.approx(axis.gains, rel=1e-11)


def test_the_saved_scenario_differs_only_in_k_b(identification, folder):
    scenario = load_scenario(str(folder / "scenario.yaml"))
    assert scenario.model == Model(kind="paper", k_b=(1.23, 2.0, 0.988))
    assert scenario.flight == identification.scenario.flight and scenario.seed == 4


def test_the_figure_is_reproducible(identification, folder, tmp_path):
    plot_identification(identification, tmp_path / "again.png")
    first, again = (folder / "identification.png", tmp_path / "again.png")
    assert first.read_bytes() == again.read_bytes()
    image = plt.imread(first)
    for row in np.array_split(image[..., :3], 4):  # Each row of each column shows something.
        for cell in np.array_split(row, 3, axis=1):
            assert (np.ptp(cell, axis=-1) > 0.3).sum() > 100

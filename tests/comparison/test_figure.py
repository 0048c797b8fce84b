"""Figure of a comparison."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.comparison.compare import VARIANTS
from aerodrake.comparison.figure import plot_comparison
from tests.flights import lost_early


def draw(short_flight, path: Path, logs=None) -> np.ndarray:
    scenario, log = short_flight
    names = ("integral", "modified", "modified+online", "clik", "fixed_weights")
    logs = dict.fromkeys(names, log) if logs is None else logs
    plot_comparison(logs, "modified+online", scenario, "title", path)
    return plt.imread(path)


def test_the_figure_shows_every_variant(short_flight, tmp_path):
    _, log = short_flight
    three = ("integral", "clik", "modified+online")
    one_row = draw(short_flight, tmp_path / "a.png", dict.fromkeys(three, log))
    draw(short_flight, tmp_path / "again.png", dict.fromkeys(three, log))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    assert min(one_row.shape[:2]) > 1000
    for missing in ("clik", "modified+online"):
        others = dict.fromkeys(set(three) - {missing}, log)
        fewer = draw(short_flight, tmp_path / "b.png", others)
        assert np.abs(one_row - fewer).max() > 0.5
    assert plt.get_fignums() == []


@pytest.mark.filterwarnings("error")
def test_the_figure_grows_with_the_number_of_variants(short_flight, tmp_path):
    _, log = short_flight
    crowded = draw(short_flight, tmp_path / "a.png", dict.fromkeys(VARIANTS, log))
    assert len(crowded) > len(draw(short_flight, tmp_path / "b.png"))


@pytest.mark.parametrize("samples", [2, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_are_drawn(samples, short_flight, tmp_path):
    """Flights end before and just after reference time 0; with and without other variants."""
    _, log = short_flight
    lost = lost_early(log, samples)
    draw(short_flight, tmp_path / "a.png", {"modified+online": lost})
    draw(short_flight, tmp_path / "b.png", {"modified+online": lost, "clik": log})
    draw(short_flight, tmp_path / "c.png", {})

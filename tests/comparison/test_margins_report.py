"""Table, figure and JSON file of margins."""

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt

from aerodrake.comparison.margin_search import Outcome, Search
from aerodrake.comparison.margins import DISTURBANCES, Margins
from aerodrake.comparison.margins_report import (
    COLUMNS,
    PANELS,
    margins_table,
    plot_margins,
    write_margins,
)
from aerodrake.scenario import Scenario

LOST = Outcome(None, "lost", "tilt of 61 deg at 2.00 s")


def fine(error_m: float) -> Outcome:
    return Outcome(error_m, "completed")


@pytest.fixture
def margins() -> Margins:
    """Margins of a variant with every kind of bracket, and of one that is lost undisturbed."""
    undisturbed = fine(0.0017)
    searches = {
        "delay_s": Search([0.0, 0.02, 0.021, 0.2], {0: undisturbed, 1: fine(0.003), 2: LOST}),
        "thrust_up": Search([1.0, 1.5, 5.0], {0: undisturbed, 1: fine(0.0034), 2: fine(0.0033)}),
        "thrust_down": Search([1.0, 0.1], {0: undisturbed, 1: fine(0.0018)}),
        "payload_kg": Search([0.0, 0.3, 2.0], {0: undisturbed, 1: fine(0.002), 2: fine(0.003)}),
    }
    lost = {name: Search(search.values, {0: LOST}) for name, search in searches.items()}
    return Margins("lap_mean_m", {"modified": searches, "clik": lost})


def test_each_disturbance_has_a_column_and_a_panel():
    assert list(COLUMNS) == list(DISTURBANCES)
    assert sorted(name for names in PANELS.values() for name in names) == sorted(DISTURBANCES)


def test_rows_contain_both_margins_of_each_disturbance(margins):
    """A cell is the last value before the event, with a sign if the event does not occur."""
    *_, modified, clik = margins_table(margins).splitlines()
    words = modified.replace("> ", ">").replace("< ", "<").split()
    assert words == ["modified", "1.70", "20", "20", "1", ">5", "<0.1", "<0.1", ">2", ">2"]
    assert clik.split(maxsplit=1) == ["clik", "lost: tilt of 61 deg at 2.00 s"]


def test_columns_are_aligned_with_their_titles(margins):
    lines = margins_table(margins).splitlines()
    titles, kinds, modified = lines[3], lines[4], lines[6]
    for title in (title for title, _ in COLUMNS.values()):
        end = titles.index(title) + len(title)
        assert kinds[:end].endswith("lost") and not kinds[end : end + 1].strip()
        assert modified[end - 1] != " "
    assert all(line == line.rstrip() for line in lines)
    assert max(len(line) for line in lines[:-1]) <= 90


def test_the_file_contains_all_flights(margins, tmp_path):
    write_margins(margins, Scenario(name="clover"), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["margins.json"]
    figures = json.loads((tmp_path / "margins.json").read_text())
    assert (figures["scenario"], figures["error"]) == ("clover", "lap_mean_m")
    assert list(figures["variants"]) == ["modified", "clik"]
    modified = figures["variants"]["modified"]
    assert modified["error_m"] == 0.0017
    assert modified["delay_s"] == {
        "doubles": {"last_before": 0.02, "first_crossed": 0.021},
        "lost": {"last_before": 0.02, "first_crossed": 0.021},
        "flown": [[0.0, 0.0017, "completed"], [0.02, 0.003, "completed"], [0.021, None, "lost"]],
    }
    assert modified["thrust_up"]["lost"] == {"last_before": 5.0, "first_crossed": None}
    assert figures["variants"]["clik"]["payload_kg"]["lost"] == {
        "last_before": None,
        "first_crossed": 0.0,
    }


def draw(margins: Margins, path: Path) -> np.ndarray:
    plot_margins(margins, "title", path)
    return plt.imread(path)


@pytest.mark.filterwarnings("error")
def test_the_figure_shows_every_variant(margins, tmp_path):
    both = draw(margins, tmp_path / "a.png")
    draw(margins, tmp_path / "again.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    assert both.shape[1] > 1000
    for name in margins.searches:
        one = Margins(margins.key, {name: margins.searches[name]})
        assert np.abs(both - draw(one, tmp_path / "b.png")).max() > 0.5
    assert plt.get_fignums() == []

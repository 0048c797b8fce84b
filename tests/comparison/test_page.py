"""`report.html` of a comparison in a browser."""

from dataclasses import replace

import pytest

from aerodrake.comparison.compare import make_variants
from aerodrake.comparison.margin_search import Outcome, Search
from aerodrake.comparison.margins import DISTURBANCES, Margins
from aerodrake.comparison.page import Comparison, changes, comparison_page
from aerodrake.comparison.table import comparison_rows, paper_rows
from aerodrake.flight.summary import failure, summarize
from tests.browser import (
    assert_ids_are_found,
    assert_no_text_is_cut,
    assert_no_wider_than_its_window,
    assert_replay_draws,
    assert_silent,
)
from tests.flights import lost_early

NAMES = ("integral", "modified", "modified+online", "clik")
NAME, CAUSE = "<b>&amp;", "<script>boom()</script>"
COMMANDS = ["aerodrake compare '<b>&amp;'", "aerodrake run 'a/b c'"]


@pytest.fixture(scope="module")
def comparison(short_flight) -> Comparison:
    """Comparison of one flight under several names and of a variant that failed, with margins."""
    scenario, log = short_flight
    scenario = replace(scenario, name=NAME)
    summaries = dict.fromkeys(NAMES, summarize(scenario, log))
    summaries |= {"fixed_weights": failure(RuntimeError(CAUSE))}
    undisturbed = Outcome(0.0017, "completed")
    search = Search([0.0, 0.5, 1.0], {0: undisturbed, 1: Outcome(0.004, "completed")})
    margins = Margins("lap_mean_m", {n: dict.fromkeys(DISTURBANCES, search) for n in NAMES})
    variants = make_variants(scenario, summaries)
    logs = dict.fromkeys(NAMES, log)
    return Comparison(scenario, variants, "modified+online", summaries, logs, margins)


@pytest.fixture(scope="module")
def path(comparison, tmp_path_factory):
    file = tmp_path_factory.mktemp("comparison") / "report.html"
    file.write_text(comparison_page(comparison, "name: resolved", COMMANDS), encoding="utf-8")
    return file


def test_the_page_opens_without_errors_and_requests(visited, path, tmp_path):
    assert_silent(visited, path, tmp_path / "report.png")


def test_no_element_is_wider_than_the_page(visited):
    assert_no_wider_than_its_window(visited.page)
    assert_no_text_is_cut(visited.page)


def test_the_replay_of_the_own_variant_draws(desktop):
    assert_replay_draws(desktop)


def test_the_page_has_the_rows_of_the_table(desktop, comparison):
    rows = desktop.page.locator("#figures-title + div tbody tr").all()
    shown = [row.locator("th, td").all_text_contents() for row in rows]
    flown = len(comparison.summaries)
    assert shown[:flown] == [
        row + [""] * (len(shown[0]) - len(row)) for row in comparison_rows(comparison.summaries)
    ]
    assert shown[flown:] == paper_rows("clover", "mean_m") == []  # The flights have no lap.


def test_names_and_causes_are_escaped(desktop, path):
    assert desktop.page.locator("h1").text_content() == NAME
    assert "boom" in desktop.page.locator("#figures-title + div").text_content()
    assert CAUSE not in path.read_text()
    assert desktop.page.locator("#again-title ~ pre").text_content().split("\n")[:2] == COMMANDS


def test_each_subject_has_a_picture(desktop):
    assert desktop.page.locator("figure h3").all_text_contents() == [
        "Errors",
        "Paths",
        "Reach",
        "Residual of modified+online",
        "Allocation and inputs of modified+online",
        "Margins",
    ]
    paths = desktop.page.locator("figure").nth(1).locator("svg text").all_text_contents()
    assert set(NAMES) <= set(paths)


def test_ids_are_unique_and_references_resolve(desktop, path):
    assert_ids_are_found(desktop.page, path)


def test_the_changes_of_a_variant_are_listed_by_key(comparison, desktop):
    listed = dict(
        (key, (before, after))
        for key, before, after in changes(comparison.scenario, comparison.variants["integral"])
    )
    assert listed == {"model.kind": ("flight", "integral"), "residual.mode": ("online", "off")}
    assert changes(comparison.scenario, comparison.scenario) == []
    table = desktop.page.locator("#scenario-title + p + div").text_content()
    assert "modified+online" in table and "nothing" in table and "residual.mode" in table


@pytest.mark.filterwarnings("error")
def test_a_comparison_without_flights_has_no_pictures(comparison):
    failed = dict.fromkeys(comparison.variants, failure(MemoryError()))
    page = comparison_page(
        comparison._replace(summaries=failed, logs={}, margins=None), "name: a", COMMANDS
    )
    assert "failed: MemoryError" in page
    assert "<figure" not in page and "<iframe" not in page and "margins-title" not in page


@pytest.mark.parametrize("samples", [2, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_have_a_page(samples, comparison):
    _, log = next(iter(comparison.logs.items()))
    logs = comparison.logs | {"modified+online": lost_early(log, samples)}
    assert "<figure" in comparison_page(comparison._replace(logs=logs), "", COMMANDS)

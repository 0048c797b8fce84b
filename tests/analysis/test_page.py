"""`report.html` of an analysis in a browser."""

from dataclasses import replace

import pytest

from aerodrake.analysis.page import analysis_page
from tests.analyses import made
from tests.browser import assert_no_text_is_cut, assert_no_wider_than_its_window

NAME = "<b>&amp;"


@pytest.fixture(scope="module")
def path(scenario, tmp_path_factory):
    analysis = replace(made(times=(0.0, 4.0)), scenario=NAME)
    file = tmp_path_factory.mktemp("analysis") / "report.html"
    page = analysis_page(analysis, scenario, "name: resolved", "aerodrake analyze 'a b'")
    file.write_text(page, encoding="utf-8")
    return file


def test_the_page_fits_and_is_silent(visited, path):
    assert_no_wider_than_its_window(visited.page)
    assert_no_text_is_cut(visited.page)
    assert visited.messages == [] and visited.requests == [path.as_uri()]


def test_the_page_has_modes_margins_and_path(desktop):
    assert desktop.page.locator("h1").text_content() == NAME
    rows = desktop.page.locator("#figures-title + div tbody tr")
    assert rows.count() == 3 and "roll 70 %, joint_2 30 %" in rows.first.text_content()
    assert desktop.page.locator("#margins-title ~ div tbody tr").count() == 3
    assert desktop.page.locator("#path-title ~ div tr.unstable").count() == 1
    assert desktop.page.locator("#again-title ~ pre").text_content() == "aerodrake analyze 'a b'\n"


def test_each_subject_has_a_picture(desktop):
    assert desktop.page.locator("figure h3").all_text_contents() == [
        "Eigenvalues",
        "Growth and frequency",
        "Mode 1",
        "Step of the force",
        "Disturbances over frequency",
        "Sensor noise over frequency",
        "Along the path",
    ]


def test_responses_of_an_unstable_loop_are_not_drawn(scenario):
    page = analysis_page(made(5.0), scenario, "", "")
    assert "Growth and frequency" in page and "since they grow without bound" in page
    assert "Step of the force" not in page and "over frequency" not in page

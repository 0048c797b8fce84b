"""`report.html` of a flight in a browser."""

import json
import re

import numpy as np
import pytest
import yaml

from aerodrake.cli import main
from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.reports.flight_page import report_page
from aerodrake.reports.flight_table import table_rows
from aerodrake.reports.page import date_of
from aerodrake.scenario.load import load_scenario
from aerodrake.scenario.plain_yaml import dump
from aerodrake.scenario.schema import as_mapping
from tests.browser import (
    PHONE,
    assert_ids_are_found,
    assert_no_text_is_cut,
    assert_no_wider_than_its_window,
    assert_replay_draws,
    assert_silent,
    pixels,
    visit,
)
from tests.flights import lost_early

NAME = "<img src=x onerror=boom()> & \"'{{ 7 * 7 }}"
"""A name with special characters of HTML, scripts and templates."""

SCENARIO = {
    "name": NAME,
    "duration": 0.8,
    "settle_s": 0.1,
    "reference": {"kind": "clover", "start_s": 0.2},
    "orientation": {"kind": "fixed", "axis": [0.0, 0.3, -1.0]},
    "residual": {"mode": "online", "gate_s": 0.0},
    "faults": [{"kind": "sample_nan", "start_s": 0.1, "duration_s": 0.4}],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a short run with all features, by the command."""
    home = tmp_path_factory.mktemp("report")
    (home / "flight.yaml").write_text(yaml.safe_dump(SCENARIO))
    main(["run", str(home / "flight.yaml"), "--quiet", "--out", str(home / "a run")])
    return home / "a run"


@pytest.fixture(scope="module")
def path(folder):
    return folder / "report.html"


@pytest.fixture(scope="module")
def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_it_opens_without_messages_and_requests(visited, path, tmp_path):
    assert_silent(visited, path, tmp_path / "report.png")


def test_the_replay_draws(desktop):
    assert_replay_draws(desktop)


def test_a_picture_is_in_the_place_of_a_replay_that_cannot_play(browser, path):
    """Without scripts, and without WebGL, and on paper; the button is not there."""
    without_webgl = "HTMLCanvasElement.prototype.getContext = () => null"
    with visit(browser, path, java_script_enabled=False) as visited:
        stage = visited.page.locator("#stage")
        assert_orange(stage)
        assert not visited.page.locator("#take").is_visible()
        assert not visited.page.locator("#still").is_visible()
    with visit(browser, path, PHONE) as visited:
        visited.page.add_init_script(without_webgl)
        visited.page.reload()
        visited.page.locator("#stage").scroll_into_view_if_needed()
        visited.page.locator("#still").wait_for()
        assert not visited.page.locator("#take").is_visible()
        visited.page.emulate_media(media="print")
        assert_orange(visited.page.locator("#stage"))


def assert_orange(place):
    seen = pixels(place)
    assert np.count_nonzero((seen[..., 0] > 0.6) & (seen[..., 2] < 0.35)) > 100


def test_the_head_is_about_the_flight(desktop, folder):
    """Its results, its date and its command, and nothing of the machine's speed."""
    labels = desktop.page.locator(".highlights dt").all_text_contents()
    assert labels == [
        "error, mean", "largest error", "pointing error, mean", "base error, mean", "largest d_o",
        "flown",
    ]  # fmt: skip
    text = desktop.page.locator("header").inner_text()
    assert "real time" not in text and " ms" not in text
    assert date_of(folder / "summary.json") in text
    assert f"aerodrake run '{folder}/scenario.yaml'" in text


def test_the_camera_is_taken_on_request(desktop):
    """Until then, scrolling over the replay scrolls the page."""
    frame, button = desktop.page.locator("#replay"), desktop.page.locator("#take")
    assert frame.evaluate("element => getComputedStyle(element).pointerEvents") == "none"
    button.click()
    assert frame.evaluate("element => getComputedStyle(element).pointerEvents") == "auto"
    assert not button.is_visible()


def test_nothing_is_wider_than_the_page(visited):
    assert_no_wider_than_its_window(visited.page)
    assert_no_text_is_cut(visited.page)


def test_figures_can_be_read_on_a_phone(phone):
    """Their type is no smaller than 7 px there, exponents left out."""
    sizes = phone.page.locator("figure svg text").evaluate_all(
        "texts => texts.filter(text => !text.querySelector('tspan'))"
        ".map(text => [parseFloat(getComputedStyle(text).fontSize), text.getScreenCTM()])"
        ".map(([size, { a, b }]) => size * Math.hypot(a, b))"
    )
    assert len(sizes) > 100 and min(sizes) > 7


def test_names_are_text(desktop, path):
    page = desktop.page
    assert page.locator("h1").text_content() == NAME
    assert page.title().startswith(NAME)
    assert page.locator("img").count() == 0
    assert "<img" not in path.read_text()


def test_it_shows_the_figures_of_the_table(desktop, summary):
    cells = desktop.page.locator("#figures-title + div td").all_text_contents()
    for _, here, there in table_rows(summary, "clover"):
        assert here in cells and there in cells
    assert "12.20 mm" in cells  # The paper's.


def test_it_shows_how_the_flight_ended_and_each_event(desktop, summary):
    assert desktop.page.locator(".ending").text_content() == summary["exit_reason"]
    rows = desktop.page.locator("#events-title + div tbody tr")
    assert rows.count() == len(summary["events"]) > 0
    assert rows.first.locator("th").text_content() == summary["events"][0]["cause"]


def test_there_is_a_picture_of_each_subject(desktop):
    titles = desktop.page.locator("figure h3").all_text_contents()
    assert titles == [
        "Paths", "Plan", "Errors", "Pointing error", "Position against reference", "Base and reach",
        "Joints", "Weight allocation", "Residual", "Inputs", "Time per tick",
        "Faults and supervisor",
    ]  # fmt: skip
    for figure in desktop.page.locator("figure").all():
        assert figure.locator("[role=img]").get_attribute("aria-label")
        assert figure.locator("svg path").count() > 10


def test_ids_are_unique_and_references_to_them_valid(desktop, path):
    assert_ids_are_found(desktop.page, path)


def test_the_chart_shows_the_systems_that_flew(desktop):
    texts = desktop.page.locator(".chart text").all_text_contents()
    for name in ("station", "coordinator", "mpc", "pointing", "sample_nan_0", "x_0"):
        assert name in texts


def test_it_shows_the_command_that_repeats_the_flight(desktop, folder, summary):
    page = desktop.page
    command = page.locator("#again-title ~ pre").text_content().strip()
    assert command == f"aerodrake run '{folder}/scenario.yaml'"
    assert f"seed {summary['seed']}" in page.locator("#again-title ~ p").text_content()
    resolved = page.locator("details pre").text_content()
    assert resolved == (folder / "scenario.yaml").read_text()
    assert summary["version"] in page.locator(".brand").text_content()


def test_the_same_flight_gives_the_same_page(folder, summary, vehicle):
    scenario = load_scenario(str(folder / "scenario.yaml"))
    log = FlightLog.read(folder / "log.npz", summary, vehicle)
    closed_loop, resolved = FlightSimulation(scenario).closed_loop, dump(as_mapping(scenario))
    flight = scenario, summary, log, closed_loop, "<p>replay</p>"
    page = report_page(*flight, resolved=resolved, folder=folder)
    again = (folder / "report.html").read_text()
    packed = re.compile(r'(<script type="application/gzip" id="packed">)[^<]*')
    assert packed.sub(r"\1", page) == packed.sub(r"\1", again)


@pytest.mark.parametrize("samples", [2, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_have_one(samples, folder, summary, vehicle):
    """Before and just after reference time 0, with NaN in the last sample."""
    log = FlightLog.read(folder / "log.npz", summary, vehicle)
    lost = lost_early(log, samples, "tilt & <b>")
    ended = summary | {"exit_reason": "lost", "exit_cause": "tilt & <b>"}
    scenario = load_scenario(folder / "scenario.yaml")
    closed_loop = FlightSimulation(scenario).closed_loop
    page = report_page(scenario, ended, lost, closed_loop, "", resolved="", folder=folder)
    assert "tilt &amp; &lt;b&gt;" in page and "<iframe" not in page

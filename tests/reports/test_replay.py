"""The recording of a flight that plays in a browser, offline."""

import base64
import re
from dataclasses import replace

import numpy as np
import pytest

from aerodrake.reports.replay import replay_page
from aerodrake.reports.scene import DOT_SPACING_M
from aerodrake.scenario import Payload


@pytest.fixture(scope="module")
def page(short_flight) -> str:
    scenario, log = short_flight
    return replay_page(log, scenario)


def messages(page: str) -> bytes:
    """Returns the recorded messages of the page to its viewer."""
    encoded = re.findall(r"base64,([A-Za-z0-9+/=]+)", page)
    return b"".join(base64.b64decode(message) for message in encoded)


def test_it_is_a_page(page):
    assert page.lstrip().lower().startswith("<!doctype html>")
    assert page.rstrip().endswith("</html>")


def test_it_loads_nothing(page):
    tags = re.findall(r"<(?:script|link|img|iframe)\b[^>]*>", page)
    assert tags
    for tag in tags:
        assert not re.search(r"(?:src|href)\s*=\s*[\"']?(?:https?:)?//", tag), tag
        assert "src=" not in tag or 'src="data:' in tag, tag


def test_it_has_the_vehicle_its_reference_and_its_trace(page):
    recorded = messages(page)
    for name in (b"/paths/reference", b"/paths/end_effector", b"visualizer"):
        assert name in recorded
    for body in (b"base", b"tool"):
        assert body in recorded


def test_it_has_the_payload_if_there_is_one(page, short_flight):
    scenario, log = short_flight
    assert b"visualizer/payload" not in messages(page)
    loaded = replay_page(log, replace(scenario, payload=Payload(mass_kg=0.2)))
    assert b"visualizer/payload" in messages(loaded)


def test_a_path_may_end_a_rounding_error_before_a_dot(short_flight):
    scenario, log = short_flight
    path = np.zeros_like(log["p_Ed_m"])
    path[-1, 0] = 10 * DOT_SPACING_M - 1e-12
    ending = replace(log, signals={**log.signals, "p_Ed_m": path})
    assert replay_page(ending, scenario)


def test_it_has_an_animation(page):
    recorded = messages(page)
    assert b"set_animation" in recorded or b"animations" in recorded


def test_the_same_flight_gives_the_same_bytes(page, short_flight):
    scenario, log = short_flight
    assert replay_page(log, scenario) == page


@pytest.mark.parametrize("samples", [1, 12])
@pytest.mark.filterwarnings("error")
def test_flights_that_ended_early_are_shown(samples, short_flight):
    """Before and just after reference time 0 (sample 11)."""
    scenario, log = short_flight
    signals = {key: rows[:samples] for key, rows in log.signals.items()}
    early = replace(log, signals=signals, exit_reason="interrupted", exit_cause="")
    assert b"/paths/end_effector" in messages(replay_page(early, scenario))


def test_a_flight_that_ends_with_nan_is_shown_up_to_there(short_flight):
    scenario, log = short_flight
    signals = {key: rows.copy() for key, rows in log.signals.items()}
    for key in ("quaternion", "p_B_m", "q_rad", "p_E_m"):
        signals[key][-1] = np.nan
    lost = replace(log, signals=signals, exit_reason="lost", exit_cause="the state is not finite")
    assert len(replay_page(lost, scenario)) > 100_000


def test_it_prints_nothing(short_flight, capfd):
    scenario, log = short_flight
    replay_page(log, scenario)
    assert capfd.readouterr() == ("", "")


def test_a_page_does_not_grow_with_the_flight(short_flight):
    """The same samples over 100 s and over 800 s give the same number of frames."""
    scenario, log = short_flight
    sizes = []
    for stretch in (200, 1600):
        long = replace(log, signals={**log.signals, "time_s": stretch * log.time_s})
        sizes.append(len(replay_page(long, scenario)))
    assert sizes[1] < 1.02 * sizes[0]

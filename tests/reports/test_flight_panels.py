"""The panels of a flight's figures."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from aerodrake.reports.flight_panels import (
    MOST_TICKS,
    draw_allocation,
    draw_boundaries,
    draw_distance,
    draw_error,
    draw_inputs,
    draw_paths,
    draw_plan,
    draw_series,
    draw_ticks,
    draw_weights,
)
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.scenario import Residual


@pytest.fixture
def axes():
    return Figure().add_subplot()


def lines(axes) -> dict[str, np.ndarray]:
    """(points, 2) of each line by its label."""
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def test_rounding_errors_in_space_do_not_fill_the_panel(short_flight):
    """After drawing, which scales the axes."""
    _, log = short_flight
    noise = 1e-9 * np.sin(np.arange(3 * len(log.time_s))).reshape(-1, 3)
    still = {key: log[key][:1] + noise for key in ("p_E_m", "p_Ed_m", "p_B_m")}
    figure = Figure()
    axes = figure.add_subplot(projection="3d")
    draw_paths(axes, replace(log, signals={**log.signals, **still}))
    FigureCanvasAgg(figure).draw()
    for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim()):
        assert high - low >= 0.49


@pytest.mark.parametrize("ticks", [0, 1, 100, MOST_TICKS + 1, 20 * MOST_TICKS + 7])
def test_the_slowest_tick_is_drawn_for_any_number_of_ticks(ticks, axes, short_flight):
    scenario, log = short_flight
    times = 1.0 + np.arange(ticks) % 7 / 10
    times[ticks // 2 : ticks // 2 + 1] = 55.0
    draw_ticks(axes, replace(log, signals={**log.signals, "tick_ms": times}), scenario)
    drawn = lines(axes)["forming and solving"]
    assert len(drawn) <= MOST_TICKS
    if ticks:
        assert drawn[:, 1].max() == 55.0
        assert abs(drawn[drawn[:, 1].argmax(), 0] - ticks // 2) < max(1, ticks / MOST_TICKS)
    assert np.all(lines(axes)["period"][:, 1] == 20.0)


def test_inputs_are_relative_to_their_bounds(axes, short_flight, vehicle):
    """One joint at half of its own acceleration, base at its bound along z."""
    scenario, log = short_flight
    qddot = np.zeros_like(log["qddot_d_rad_s2"])
    qddot[:, 2] = -0.5 * vehicle.acceleration[2]
    a_Bd = np.zeros_like(log["a_Bd_m_s2"])
    a_Bd[:, 2] = scenario.mpc.base_acceleration_m_s2[2]
    log = replace(log, signals={**log.signals, "qddot_d_rad_s2": qddot, "a_Bd_m_s2": a_Bd})
    draw_inputs(axes, log, scenario)
    drawn = lines(axes)
    np.testing.assert_allclose(drawn["joints"][:, 1], 0.5)
    np.testing.assert_allclose(drawn["base"][:, 1], 1.0)


def test_distances_and_their_boundaries_are_all_within_the_panel(axes, short_flight):
    scenario, log = short_flight
    far = replace(log, signals={**log.signals, "p_E_m": log["p_E_m"] + [0.0, 0.0, 0.9]})
    for flown in (log, far):
        draw_distance(axes, flown)
    draw_boundaries(axes, scenario)
    low, high = axes.get_ylim()
    assert low == 0 and high > 0.85
    heights = [line.get_ydata()[0] for line in axes.lines[2:]]
    assert heights == [scenario.allocation.d_h_m, scenario.allocation.d_edge_m]


@pytest.mark.parametrize("error_mm", [1e-4, 2e-3, 0.5, 300.0])
def test_errors_are_not_clipped_below_what_is_flown(error_mm, axes, short_flight):
    _, log = short_flight
    there = {"p_E_m": log["p_Ed_m"] + [0, 0, 1e-3 * error_mm], "p_B_m": log["p_Bd_m"]}
    draw_error(axes, replace(log, signals={**log.signals, **there}))
    low, high = axes.get_ylim()
    assert low <= error_mm * (1 + 1e-6) and error_mm < high
    np.testing.assert_allclose(lines(axes)["end-effector"][:, 1], error_mm, rtol=1e-6)


@pytest.mark.parametrize(
    "draw", [draw_error, draw_series, draw_weights, draw_allocation, draw_plan]
)
def test_legends_are_off_the_curves(draw, short_flight):
    """They are above the panel."""
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    more = {"key": "q_rad", "convert": np.degrees, "label": "q"} if draw is draw_series else {}
    draw(axes, short_flight[1], **more)
    FigureCanvasAgg(figure).draw()
    legend = axes.get_legend().get_window_extent()
    assert legend.y0 >= axes.get_window_extent().y1 - 1
    assert legend.y1 <= figure.bbox.y1


@pytest.mark.parametrize("mode", ["off", "offline", "online"])
def test_a_flight_without_residual_has_no_picture_of_it(mode, short_flight):
    scenario, log = short_flight
    scenario = replace(scenario, residual=Residual(mode=mode))
    titles = [picture.title for picture in flight_pictures(log, scenario)]
    assert ("Residual" in titles) == (mode != "off") and "Errors" in titles


def test_the_error_axis_increases_for_small_errors(axes, short_flight):
    _, log = short_flight
    still = replace(log, signals={**log.signals, "p_E_m": log["p_Ed_m"] + 1e-9})
    draw_error(axes, still)
    low, high = axes.get_ylim()
    assert low < high

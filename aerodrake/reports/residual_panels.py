"""Panels of the estimated and the true residual Delta."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from aerodrake.flight.log import FlightLog
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.reports.figures import ACCENT, AXIS_COLORS, EDGE, legend_above, widen
from aerodrake.scenario import Scenario

MOST_RATIO = 10.0
"""Largest ratio of the limits of a panel to the true values in it."""


def draw_residual(panels: Sequence[Axes], log: FlightLog, scenario: Scenario) -> None:
    """Draws estimated and true Delta along each world axis, in one of `panels` each.

    A panel ends at `MOST_RATIO` times the true Delta, so that one that diverges leaves it.
    """
    times, estimated, true = residuals(log, scenario)
    for axis, axes in enumerate(panels):
        axes.plot(times, 1e3 * true[:, axis], color=EDGE, label="true")
        axes.plot(times, 1e3 * estimated[:, axis], color=AXIS_COLORS[axis], label="estimated")
        axes.margins(x=0, y=0.15)
        widen(axes.yaxis, 1.0)
        _limit(axes, 1e3 * true[:, axis])
        legend_above(axes, 2)


def draw_prediction(axes: Axes, log: FlightLog) -> None:
    """Draws the error of predicting the base velocity over one period, with and without Delta.

    The panel ends at `MOST_RATIO` times the error without Delta.
    """
    for key, label, color in (
        ("nominal_prediction_error_m_s", "without Delta", EDGE),
        ("prediction_error_m_s", "with Delta", ACCENT),
    ):
        axes.plot(log.time_s, 1e3 * np.linalg.norm(log[key], axis=1), color=color, label=label)
    widen(axes.yaxis, 1.0)
    _limit(axes, 1e3 * np.linalg.norm(log["nominal_prediction_error_m_s"], axis=1))
    axes.set_ylim(bottom=0)
    axes.set_ylabel("error / mm/s")
    legend_above(axes, 2)


def _limit(axes: Axes, true: np.ndarray) -> None:
    """Ends the y axis at `MOST_RATIO` times the largest of `true`, or of 1."""
    most = MOST_RATIO * np.max(np.abs(true), initial=1.0, where=np.isfinite(true))
    low, high = axes.get_ylim()
    axes.set_ylim(max(low, -most), min(high, most))


def residuals(log: FlightLog, scenario: Scenario) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns times (K,) s, and estimated (K, 3) and true (K, 3) Delta, at each tick.

    Delta is in the unit of the scenario's model, and NaN in the integral model, which has none.

    At tick k the estimator has the errors of the prediction of one period with
    c Delta_{k-1} and without it. The negative error without it is the true c Delta; the
    difference of the two errors is the estimated one.
    """
    period = scenario.rates.mpc_period_s
    gain = EquivalentModel.of(scenario, log["q_rad"].shape[1]).residual_gain
    gain = np.where(gain > 0, gain, np.nan)
    # The log has several samples for each tick, with the results of tick k from the next on.
    stride = round(period / scenario.rates.flight_period_s)
    ticks = np.arange(3 * stride, len(log.time_s), stride)
    start = log.time_s[log.is_flown][0]
    ticks = ticks[log.time_s[ticks] >= start + 2 * period]
    nominal = log["nominal_prediction_error_m_s"][ticks]
    estimated = (log["prediction_error_m_s"][ticks] - nominal) / gain
    return log.time_s[ticks] - 2 * period, estimated, -nominal / gain

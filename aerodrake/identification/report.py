"""Table, figure and files of an identification."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.signal import lsim

from aerodrake.flight.summary import rounded, to_json
from aerodrake.identification.identify import AxisIdentification, Identification, Record
from aerodrake.model.equivalent.identification import LEVEL
from aerodrake.reports.drawable import drawable_values
from aerodrake.reports.drawing import drawing
from aerodrake.reports.figures import (
    ACCENT,
    AXIS_COLORS,
    INK,
    REFERENCE,
    STYLE,
    legend_above,
    write_png,
)
from aerodrake.scenario.load import save_scenario
from aerodrake.support.version import __version__

FIGURE = "identification.png"

RESULTS = ("identification.json", "scenario.yaml")
"""Files that every identification has, also if it could not be drawn."""

PAPER_K_B = (6.67, 6.67, 2.38)
"""1/s, K_B of the paper's vehicle."""


def as_figures(identification: Identification, command: str) -> dict[str, Any]:
    """Returns the content of `identification.json`.

    Keys:
        command: Command that repeats the identification.
        interface, position_gain, velocity_gain: Flight controller for which K_B is valid.
        k_b: 1/s, to three digits, as in `scenario.yaml` of the same folder.
        scenario_k_b, paper_k_b: 1/s, K_B of the given scenario, and of the paper.
        axes: For each axis K_B, its interval at the confidence `level`, R^2, and K_B by the
            motion of the arm.
    """
    scenario = identification.scenario
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "version": __version__,
        "command": command,
        "interface": scenario.flight.interface,
        "position_gain": scenario.flight.position_gain,
        "velocity_gain": scenario.flight.velocity_gain,
        "k_b": identification.k_b,
        "scenario_k_b": scenario.model.k_b,
        "paper_k_b": PAPER_K_B,
        "level": LEVEL,
        "axes": {
            name: {
                "k_b": rounded(axis.fit.gain),
                "interval": [rounded(bound) for bound in axis.fit.interval],
                "r2": rounded(axis.fit.r2),
                "k_b_by_arm": {arm: rounded(gain) for arm, gain in axis.gains.items()},
            }
            for name, axis in identification.axes.items()
        },
    }


def write_results(identification: Identification, command: str, folder: Path) -> None:
    """Writes `RESULTS` into an existing folder; `command` repeats the identification."""
    figures = as_figures(identification, command)
    (folder / "identification.json").write_text(to_json(figures), encoding="utf-8")
    save_scenario(identification.identified_scenario, folder)


def draw(identification: Identification, folder: Path) -> None:
    """Adds `identification.png` to the folder; reports if that fails."""
    path = folder / FIGURE
    with drawing(path):
        plot_identification(identification, path)


def table(identification: Identification) -> str:
    """Returns a table of K_B with the scenario's and the paper's."""
    scenario = identification.scenario
    lines = [
        f"{scenario.name}: K_B of the base, flight.interface {scenario.flight.interface}, in 1/s",
        "",
        f"{'axis':<6}{'K_B':>7}{f'{LEVEL:.0%} interval':>18}{'R^2':>8}{'arm still':>11}"
        f"{'moving':>9}{'scenario':>11}{'paper':>8}",
    ]
    axes = zip(identification.axes.items(), scenario.model.k_b, PAPER_K_B, strict=True)
    for (name, axis), own, paper in axes:
        low, high = axis.fit.interval
        lines.append(
            f"{name:<6}{axis.fit.gain:>7.3f}{f'{low:.3f} .. {high:.3f}':>18}{axis.fit.r2:>8.3f}"
            f"{axis.gains['still']:>11.3f}{axis.gains['moving']:>9.3f}{own:>11.2f}{paper:>8.2f}"
        )
    return "\n".join(lines)


def plot_identification(identification: Identification, path: Path) -> None:
    """Writes the figure: response, measured and fitted velocity, residual and fit of each axis."""
    with rc_context(STYLE):
        figure = Figure(figsize=(15, 11), dpi=110, layout="constrained")
        scenario = identification.scenario
        title = f"{scenario.name}: flight.interface {scenario.flight.interface}"
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        rows = figure.subplots(4, 3)
        columns = zip(rows.T, identification.axes.items(), AXIS_COLORS, strict=True)
        for column, (name, axis), color in columns:
            k, (low, high), r2 = axis.fit.gain, axis.fit.interval, axis.fit.r2
            title = f"{name}: K_B = {k:.3f} ({low:.3f} to {high:.3f}) 1/s, R^2 = {r2:.3f}"
            column[0].set_title(title, parse_math=False, pad=22)  # Above the legend.
            axis = _drawable(axis)
            _response(column[0], axis)
            _velocity(column[1], axis)
            _residual(column[2], axis, color)
            _fit(column[3], axis, color)
        labels = ("p - p(0) / m", "v / m/s", "residual / m/s", "v / m/s")
        for row, label in zip(rows, labels, strict=True):
            row[0].set_ylabel(label)
        for axes in rows[:3].flat:
            axes.set_xlabel("time / s")
        write_png(figure, path)


def _drawable(axis: AxisIdentification) -> AxisIdentification:
    records = {
        arm: Record(*(drawable_values(getattr(record, field.name)) for field in fields(record)))
        for arm, record in axis.records.items()
    }
    return replace(axis, records=records)


def _response(axes: Axes, axis: AxisIdentification) -> None:
    """Draws the response of the base and of the model to the same setpoint, with the arm still."""
    record, k = axis.records["still"], axis.fit.gain
    p_d = record.p_d - record.p_d[0]
    _, model, _ = lsim(([k], [1.0, k]), p_d, record.time_s)
    axes.plot(record.time_s, record.p - record.p_d[0], color=ACCENT, linewidth=2.2, label="base")
    axes.plot(record.time_s, model, color=INK, linewidth=0.9, label="model")
    axes.plot(record.time_s, p_d, **REFERENCE, alpha=0.5, label="p_d")
    axes.margins(y=0.2)
    legend_above(axes, 3)


def _velocity(axes: Axes, axis: AxisIdentification) -> None:
    """Draws the measured and the fitted velocity."""
    record = axis.records["still"]
    axes.plot(record.time_s, record.v, color=ACCENT, linewidth=2.2, label="measured")
    axes.plot(record.time_s, _fitted(axis, record), color=INK, linewidth=0.9, label="fitted")
    axes.margins(y=0.2)
    legend_above(axes, 2)


def _residual(axes: Axes, axis: AxisIdentification, color: str) -> None:
    """Draws the error of the fitted velocity."""
    for (arm, record), alpha in zip(axis.records.items(), (1.0, 0.5), strict=True):
        residual = record.v - _fitted(axis, record)
        axes.plot(record.time_s, residual, color=color, alpha=alpha, label=f"arm {arm}")
    legend_above(axes, 2)


def _fit(axes: Axes, axis: AxisIdentification, color: str) -> None:
    """Draws velocity over position error, and the fitted line."""
    for (arm, record), alpha in zip(axis.records.items(), (0.5, 0.2), strict=True):
        error = record.p_d - record.p
        axes.plot(error, record.v, ".", color=color, alpha=alpha, markersize=2, label=f"arm {arm}")
    record = axis.records["still"]
    ends = np.array([np.argmin(record.p_d - record.p), np.argmax(record.p_d - record.p)])
    axes.plot((record.p_d - record.p)[ends], _fitted(axis, record)[ends], color=INK, label="fit")
    axes.set_xlabel("p_d - p / m")
    legend_above(axes, 3)


def _fitted(axis: AxisIdentification, record: Record) -> np.ndarray:
    """Returns (T,) m/s, K_B (p_d - p) plus the constant of this flight."""
    error = record.p_d - record.p
    return axis.fit.gain * (error - error.mean()) + record.v.mean()

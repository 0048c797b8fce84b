"""Table and figure of the training of a network."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from aerodrake.learning.evaluation import METHODS, NetworkEvaluation
from aerodrake.model.residual.training import TrainingResult
from aerodrake.reports.drawable import drawable_values
from aerodrake.reports.figures import (
    ACCENT,
    AXIS_COLORS,
    INK,
    REFERENCE,
    STYLE,
    cover,
    cover_positive,
    legend_above,
    write_png,
)

LEAST_LOSS = 1e-12
"""Smallest loss that the figure shows."""


class DeltaFlight(NamedTuple):
    """Delta of a network on a flight.

    Attributes:
        title: Title of the figure.
        period_s: s, period of the rows.
        unit: Unit of Delta.
        estimated, true: (T, 3) Delta of the network, and from the measured velocity.
    """

    title: str
    period_s: float
    unit: str
    estimated: np.ndarray
    true: np.ndarray


def training_table(evaluation: NetworkEvaluation) -> str:
    """Returns the table of RMS errors by run and method in mm/s, with a summary."""
    width = max(len(run.name) for run in evaluation.runs) + 2
    lines = [
        "RMS error of the base velocity predicted one period ahead, mm/s, on held-out flights",
        "",
        f"{'':<{width}}" + "".join(f"{method:>9}" for method in METHODS) + f"{'recovered':>11}",
    ]
    for i, (run, rmse) in enumerate(zip(evaluation.runs, evaluation.rmse, strict=True)):
        numbers = "".join(f"{1e3 * rmse[method]:9.2f}" for method in METHODS)
        recovered = _percent(evaluation.recovered(i))
        lines.append(f"{run.name:<{width}}{numbers}{recovered:>11}".rstrip())
    lines += [
        "",
        f"offline network: removes {_percent(evaluation.removed)} or more of the calm-air residual",
        f"online learning: removes {_percent(evaluation.least_recovered) or 'nothing'} or more of "
        "the error that wind and payload add, where that is 10 % or more",
        f"offline network: error at most {evaluation.worst:.2f} times that without a network",
    ]
    return "\n".join(lines)


def plot_training(result: TrainingResult, delta: DeltaFlight, path: Path) -> None:
    """Writes the figure, a PNG: losses by epoch, and Delta on a held-out flight."""
    with rc_context(STYLE):
        figure = Figure(figsize=(10, 9), dpi=120, layout="constrained")
        losses, *axes = figure.subplots(4, 1, height_ratios=[1.6, 1, 1, 1])
        epochs = 1 + np.arange(len(result.training_loss))
        both = [np.array(loss) for loss in (result.training_loss, result.validation_loss)]
        training, validation = map(drawable_values, both)
        losses.plot(epochs, training, color=INK, label="training")
        losses.plot(epochs, validation, color=ACCENT, label="validation")
        cover_positive(losses, np.concatenate([training, validation]), LEAST_LOSS)
        losses.axvline(result.best_epoch + 1, color=INK, linewidth=0.8, linestyle=":")
        losses.set(xlabel="epoch", ylabel="squared error / squared residual")
        legend_above(losses, 2)
        times = delta.period_s * np.arange(len(delta.true))
        for axis, (plot, name) in enumerate(zip(axes, "xyz", strict=True)):
            true = 1e3 * drawable_values(delta.true[:, axis])
            plot.plot(times, true, **REFERENCE, label="true", zorder=3)
            estimated = 1e3 * drawable_values(delta.estimated[:, axis])
            plot.plot(times, estimated, color=AXIS_COLORS[axis], label="estimated")
            plot.set_ylabel(f"Delta {name} / m{delta.unit}")
            cover(plot, times)
            legend_above(plot, 2)
        axes[0].set_title(delta.title, parse_math=False, loc="left")
        axes[-1].set_xlabel("time / s")
        write_png(figure, path)


def _percent(part: float | None) -> str:
    return "" if part is None else f"{100 * part:.0f} %"

"""What a person sees of training: the table and the figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from aerodrake.learning.evaluation import METHODS, Evaluation
from aerodrake.model.residual.training import Trained
from aerodrake.reports.figures import ACCENT, AXIS_COLORS, INK, REFERENCE, STYLE, write_png


def training_table(evaluation: Evaluation) -> str:
    """RMS errors by flight and method in mm/s, and what follows from them."""
    width = max(len(stage.name) for stage in evaluation.stages) + 2
    lines = [
        "RMS error of the base velocity predicted one period ahead, mm/s, on flights held out",
        "",
        f"{'':<{width}}" + "".join(f"{method:>9}" for method in METHODS) + f"{'recovered':>11}",
    ]
    for i, (stage, rmse) in enumerate(zip(evaluation.stages, evaluation.rmse, strict=True)):
        numbers = "".join(f"{1e3 * rmse[method]:9.2f}" for method in METHODS)
        lines.append(
            f"{stage.name:<{width}}{numbers}{_percent(evaluation.recovered(i)):>11}".rstrip()
        )
    return "\n".join(
        [
            *lines,
            "",
            f"offline removes {_percent(evaluation.removed)} or more of the residual in calm air",
            f"online recovers {_percent(evaluation.least_recovered) or 'nothing'} or more of what "
            "wind and payload add, where that is 10 % or more",
            f"offline is at most {evaluation.worst:.2f} times as wrong as no network",
        ]
    )


def plot_training(
    trained: Trained, estimated: np.ndarray, true: np.ndarray, period: float, title: str, path: Path
) -> None:
    """Writes the figure: losses by epoch, and Delta on a flight held out.

    Args:
        trained: With its losses.
        estimated: (T, 3) m/s, the network's Delta.
        true: (T, 3) m/s.
        period: s.
        title: Of the flight held out.
        path: Of the PNG.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(10, 9), dpi=120, layout="constrained")
        losses, *axes = figure.subplots(4, 1, height_ratios=[1.6, 1, 1, 1])
        epochs = 1 + np.arange(len(trained.training_loss))
        losses.semilogy(epochs, trained.training_loss, color=INK, label="training")
        losses.semilogy(epochs, trained.validation_loss, color=ACCENT, label="validation")
        losses.axvline(trained.best_epoch + 1, color=INK, linewidth=0.8, linestyle=":")
        losses.set(xlabel="epoch", ylabel="part of the residual's power left")
        losses.legend(loc="upper right", ncols=2)
        times = period * np.arange(len(true))
        for axis, (plot, name) in enumerate(zip(axes, "xyz", strict=True)):
            plot.plot(times, 1e3 * true[:, axis], **REFERENCE, label="true", zorder=3)
            plot.plot(times, 1e3 * estimated[:, axis], color=AXIS_COLORS[axis], label="estimated")
            plot.set_ylabel(f"Delta {name} / mm/s")
            plot.set_xlim(0, times[-1])
            plot.legend(loc="upper right", ncols=2)
        axes[0].set_title(title, parse_math=False)
        axes[-1].set_xlabel("time / s")
        write_png(figure, path)


def _percent(part: float | None) -> str:
    return "" if part is None else f"{100 * part:.0f} %"

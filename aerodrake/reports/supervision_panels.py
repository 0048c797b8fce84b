"""Panels of faults, conditions of the supervisor, and safe modes."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from aerodrake.flight.events import Span
from aerodrake.flight.log import FlightLog
from aerodrake.model.supervision.safe_mode import SafeMode

SAFE_MODE_COLORS = {
    SafeMode.NOMINAL: "#868e96",
    SafeMode.HOLD: "#ffe066",
    SafeMode.DESCEND: "#ffa94d",
    SafeMode.STOP: "#fa5252",
}
FAULT_COLOR = "#495057"


def shade_safe_modes(axes: Axes, log: FlightLog) -> None:
    """Shades the times in which the supervisor is not in NOMINAL."""
    mode = log["supervisor_mode"].astype(int)
    edges = np.flatnonzero(np.diff(mode)) + 1
    for start, end in zip([0, *edges], [*edges, len(mode) - 1], strict=True):
        if mode[start] != SafeMode.NOMINAL:
            color = SAFE_MODE_COLORS[SafeMode(mode[start])]
            axes.axvspan(log.time_s[start], log.time_s[end], color=color, alpha=0.35, linewidth=0)


def draw_spans(axes: Axes, spans: Sequence[Span]) -> None:
    """Draws a bar for each time span of a fault or condition, one row for each name."""
    rows = list(dict.fromkeys((span.mode is None, span.name) for span in spans))
    for span in spans:
        row = rows.index((span.mode is None, span.name))
        color = FAULT_COLOR if span.mode is None else SAFE_MODE_COLORS[span.mode]
        length = max(span.end_s - span.start_s, 0.02)  # Long enough to be visible.
        axes.barh(row, length, left=span.start_s, height=0.6, color=color, linewidth=0)
    labels = [f"{name} (injected)" if is_fault else name for is_fault, name in rows]
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    for mode in sorted({span.mode for span in spans if span.mode is not None}):
        axes.barh([0], [0], color=SAFE_MODE_COLORS[mode], label=mode.label)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0))

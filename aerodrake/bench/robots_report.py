"""Table of the mounted arms."""

from collections.abc import Mapping
from typing import Any

FILE = "robots.json"
"""File of the figures."""
COLUMNS = ("<14", *[">8"] * 6, ">10", ">11", "")
"""Alignment and width of the columns."""


def robots_table(figures: Mapping[str, Any]) -> str:
    """Returns the figures of all arms as text."""
    rows = [
        ("", "joints", "arm", "base", "reach", "mean", "max", "torque", "delay"),
        ("arm", "", "kg", "kg", "m", "mm", "mm", "at limit", "margin ms"),
        *(_row(arm) for arm in figures["arms"]),
    ]
    return "\n".join("".join(map(format, row, COLUMNS)).rstrip() for row in rows)


def _row(arm: Mapping[str, Any]) -> tuple[str, ...]:
    error, delay = arm["error"], arm["delay_margin_s"]
    if not arm["is_stable"]:
        margin = "unstable"
    else:
        margin = "-" if delay is None else f"{1e3 * delay:.0f}"
    ended = (
        "" if arm["exit_reason"] == "completed" else f"  {arm['exit_reason']}: {arm['exit_cause']}"
    )
    return (
        arm["name"],
        str(arm["joints"]),
        *(f"{arm[key]:.1f}" for key in ("arm_kg", "base_kg")),
        f"{arm['reach_m']:.2f}",
        *("-" if error[key] is None else f"{1e3 * error[key]:.3f}" for key in ("mean_m", "max_m")),
        f"{100 * arm['torque_at_limit']:.0f} %",
        margin,
        ended,
    )

"""The table of a flight's results beside those of the paper.

`summary` is the summary of the flight, see `summarize`; `kind` is the kind of its reference.
"""

from typing import Any

import numpy as np

from aerodrake.flight.events import DELTA_UNUSED
from aerodrake.flight.summary import HEADLINES, headline, millimetres
from aerodrake.model.supervision.safe_mode import SafeMode

PAPER = {
    "clover": {"lap_mean_m": 0.0122, "integral_lap_mean_m": 0.0302},
    "moving_target": {"settled_mean_m": 0.0197, "approach_s": 5.0},
}
"""Results of the paper by kind of reference and key of `summary["error"]`.

The prefix `integral_` marks those of its integral model; the others are of its method.
"""

SOURCES = ("time with learned Delta", "time with offline Delta", "time without Delta")
"""Labels of the durations in `summary["residual"]["source_s"]`."""

LEAST_SHARE = 0.0005
"""Least share of the time with its torque at the limit for which a joint is in a table."""

MOST_EVENTS = 20
"""Largest number of events in a table."""


def table_rows(summary: dict[str, Any], kind: str) -> list[tuple[str, str, str]]:
    """Returns the label, our value and the paper's value, if any, of each row.

    Labels of subordinate rows begin with two blanks.
    """
    paper, error, mpc = PAPER.get(kind, {}), summary["error"], summary["mpc"]
    angle, base = summary["orientation"], summary["base_error"]
    rows = [("end-effector error", "", "")]
    for key, label in (
        ("lap_mean_m", "mean over one lap"),
        ("settled_mean_m", "mean after 15 s"),
        ("mean_m", "mean"),
        ("rms_m", "rms"),
        ("max_m", "max"),
    ):
        rows.append((f"  {label}", _mm(error[key]), _mm(paper.get(key))))
    approach = _unit(error["approach_s"], "s"), _unit(paper.get("approach_s"), "s")
    rows.append(("  first within d_h", *approach))
    rows += _followed_rows(summary)
    if angle["mean_rad"] is not None:
        rows.append(("pointing error, mean", _deg(angle["mean_rad"]), ""))
        rows.append(("pointing error, max", _deg(angle["max_rad"]), ""))
    rows += [
        ("base error, mean", _mm(base["mean_m"]), ""),
        ("base error, max", _mm(base["max_m"]), ""),
        ("MPC tick, median", _unit(mpc["median_ms"], "ms"), ""),
        ("MPC tick, p99", _unit(mpc["p99_ms"], "ms"), ""),
        ("MPC fallbacks", f"{mpc['solver_fallbacks']} of {mpc['ticks']}", ""),
    ]
    solved = {name: count for name, count in mpc["solved_by"].items() if count and name != "none"}
    rows += [(f"MPC ticks, {name}", str(count), "") for name, count in solved.items()]
    if mpc["missed"]:
        rows.append(("MPC ticks missed", f"{mpc['missed']} of {mpc['missed'] + mpc['ticks']}", ""))
    rows += [
        (f"supervisor in {mode}", _unit(seconds, "s"), "")
        for mode, seconds in summary["safe_modes"].items()
        if seconds and mode != SafeMode.NOMINAL.label
    ]
    rows += [
        (f"time in mode {mode}", _unit(seconds, "s"), "")
        for mode, seconds in summary["modes"].items()
        if seconds
    ]
    rows += _torque_rows(summary)
    rows += _residual_rows(summary)
    rows += [
        ("largest reachable d_o", f"{summary['arm']['farthest_reach_m']:.2f} m", ""),
        ("  d_edge of allocation", f"{summary['arm']['d_edge_m']:.2f} m", "0.38 m"),
    ]
    return rows


def _followed_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Returns the rows of the followed reference; none if it is the one that was asked for."""
    followed = summary.get("followed_error")  # A summary of an earlier version has none.
    if followed is None:
        return []
    return [
        ("reference not followed", _unit(summary["refused_s"], "s"), ""),
        ("  error from followed", _mm(followed["mean_m"]), ""),
    ]


def _torque_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Returns the joints with their torque at the limit, and for which share of the time."""
    shares = summary["arm"].get("torque_at_limit", {})  # A summary of an earlier version has none.
    rows = [
        (f"  {joint}", f"{100 * share:.1f} %", "")
        for joint, share in shares.items()
        if share >= LEAST_SHARE
    ]
    return [("torque at limit", "of the time", ""), *rows] if rows else []


def _residual_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Returns the rows of Delta and its learning; none in the mode `off`."""
    residual = summary["residual"]
    if residual["source_s"] is None:
        return []
    rows = [
        (label, _unit(seconds, "s"), "")
        for label, seconds in zip(SOURCES, residual["source_s"].values(), strict=True)
        if seconds
    ]
    if any(event["cause"] == DELTA_UNUSED for event in summary["events"]):
        rows = [("residual Delta", "never used", "")]
    if residual["stable_learning_rate"] is not None:
        rows.append(("learning rate", f"{residual['learning_rate']:.2g}", ""))
        rows.append(("  stable below", f"{residual['stable_learning_rate']:.2g}", ""))
    return rows


def summary_notes(summary: dict[str, Any]) -> list[str]:
    """Returns notes on the results of a flight."""
    rate, bound = (summary["residual"][key] for key in ("learning_rate", "stable_learning_rate"))
    if bound is None or rate < bound:
        return []
    return [
        f"residual.learning_rate {rate:.2g} exceeds {bound:.2g}, the bound below which every step "
        "of this flight's online learning is stable"
    ]


def highlights(summary: dict[str, Any], kind: str) -> list[tuple[str, str, str]]:
    """Returns the label, the value and a note of the few results that matter most."""
    key = headline({summary["scenario"]: summary})
    paper = PAPER.get(kind, {}).get(key)
    error, angle, arm = summary["error"], summary["orientation"]["mean_rad"], summary["arm"]
    farthest = arm["farthest_d_o_m"]
    first = [
        (f"error, {HEADLINES[key]}", _mm(error[key]), f"the paper: {_mm(paper)}" if paper else ""),
        ("largest error", _mm(error["max_m"]), "of the end-effector"),
    ]
    if angle is not None:
        first.append(("pointing error, mean", _deg(angle), ""))
    return [
        *first,
        ("base error, mean", _mm(summary["base_error"]["mean_m"]), "from its setpoint"),
        ("largest d_o", _mm(farthest), f"of {arm['d_edge_m']:.2f} m, d_edge"),
        ("flown", f"{summary['simulated_s']:.1f} s", "with the initial hover"),
    ]


def ending(summary: dict[str, Any]) -> str:
    """Returns the exit reason of a flight with its cause."""
    cause = summary["exit_cause"]
    return summary["exit_reason"] + (f" ({cause})" if cause else "")


def instability(summary: dict[str, Any]) -> str:
    """Returns the sentence of an unstable hover, empty if there is none."""
    return summary.get("instability") or ""  # Missing if the process failed.


def table(summary: dict[str, Any], kind: str) -> str:
    """Returns ending, `table_rows`, first events and `summary_notes` of a flight as text.

    An instability follows the ending.
    """
    rows = table_rows(summary, kind)
    lines = [
        f"{summary['scenario']}: {ending(summary)}",
        *filter(None, [instability(summary)]),
        f"{summary['simulated_s']:.1f} s simulated in {summary['wall_s']:.1f} s, "
        f"{summary['real_time_factor']:.1f} x real time",
        "",
        f"{'':<24}{'here':>12}{'paper':>12}",
        *(f"{name:<24}{here:>12}{there:>12}".rstrip() for name, here, there in rows),
    ]
    lines += [""] * bool(summary["events"])
    lines += [
        f"{event['time_s']:8.2f} s  {event['cause']}"
        + (f" ({event['joint']})" if event.get("joint") else "")
        + f" {event['event']}"
        + (f": {event['mode']}" if event["event"] == "triggered" else "")
        for event in summary["events"][:MOST_EVENTS]
    ]
    left = len(summary["events"]) - MOST_EVENTS
    if left > 0:
        lines.append(f"{'':11} and {left} more, in summary.json")
    lines += [f"\nnote: {note}" for note in summary_notes(summary)]
    return "\n".join(lines)


def _mm(value: float | None) -> str:
    return "" if value is None else f"{millimetres(value)} mm"


def _deg(value: float) -> str:
    return f"{np.degrees(value):.3f} deg"


def _unit(value: float | None, unit: str) -> str:
    return "" if value is None else f"{value:.2f} {unit}"

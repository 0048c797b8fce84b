"""Table of an analysis."""

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.margins import StabilityLimit, StabilityMargin

MOST_MODES = 8
"""Largest number of modes in a table."""
MOST_MOTIONS, MOST_SYSTEMS = 2, 1
"""Largest numbers of motions and of systems of a mode in a table."""

MARGINS = {"base_delay": "base delay", "rotor_gain": "rotor gain", "joint_gain": "joint gain"}
"""Labels of the margins."""

TITLES = (("growth", "1/s"), ("freq.", "Hz"), ("damping", ""))
NAME, CELL, LIMIT = 20, 9, 20
"""Widths in the table."""


def mode_row(point: OperatingPoint, mode: Eigenmode) -> list[str]:
    """Returns growth, frequency, damping, and the motions and systems with the largest shares."""
    motions = point.motions(mode)
    systems = [participant for participant in mode.participants if participant not in motions]
    return [
        f"{mode.growth_1_s:+.2f}",
        f"{mode.frequency_hz:.2f}",
        f"{mode.damping:.3f}",
        *(
            ", ".join(f"{name} {100 * share:.0f} %" for name, share in group[:most])
            for group, most in ((motions, MOST_MOTIONS), (systems, MOST_SYSTEMS))
        ),
    ]


def mode_rows(point: OperatingPoint) -> list[list[str]]:
    """Returns the number and the `mode_row` of each of the least damped modes."""
    modes = point.least_damped[:MOST_MODES]
    return [[str(number), *mode_row(point, mode)] for number, mode in enumerate(modes, start=1)]


def path_rows(analysis: Analysis) -> list[list[str]]:
    """Returns the reference time and the `mode_row` of the least damped mode along the path."""
    return [
        [f"{point.time_s:.2f} s", *mode_row(point, mode)]
        for point in analysis.path
        for mode in point.least_damped[:1]
    ]


def margin_rows(analysis: Analysis) -> list[list[str]]:
    """Returns label, lower and upper limit of each margin, empty where the search has no side.

    There are none if the loop is unstable in hover.
    """
    if not analysis.hover.is_stable:
        return []
    return [
        [MARGINS.get(margin.name, margin.name)]
        + [
            _limit(margin, limit, end)
            for limit, end in zip((margin.lower, margin.upper), margin.end, strict=True)
        ]
        for margin in analysis.margins
    ]


def highlights(analysis: Analysis) -> list[tuple[str, str, str]]:
    """Returns the label, the value and a note of the least damped mode and of each margin."""
    shown = []
    for mode in analysis.hover.least_damped[:1]:
        label = "least damped" if mode.is_stable else "fastest growing"
        note = f"damping ratio {mode.damping:.3f}"
        shown.append((label, f"{mode.frequency_hz:.1f} Hz", note))
    for margin in analysis.margins if analysis.hover.is_stable else ():
        limits = (margin.lower, margin.upper)
        ends = [
            f"{'' if limit else f'{beyond} '}{_number(margin, limit.value if limit else end)}"
            for limit, end, beyond in zip(limits, margin.end, "<>", strict=True)
            if end != margin.nominal
        ]
        hertz = [f"{limit.frequency_hz:.1f} Hz" for limit in limits if limit]
        note = f"unstable beyond, at {' and '.join(hertz)}" if hertz else "stable throughout"
        unit = " ms" if margin.kind == "delay" else ""
        label = MARGINS.get(margin.name, margin.name)
        shown.append((label, f"{' to '.join(ends)}{unit}", note))
    return shown


def analysis_table(analysis: Analysis) -> str:
    """Returns sentence, least damped modes, margins and path of an analysis as text."""
    lines = [f"{analysis.scenario}: {analysis.sentence}", ""]
    lines += _mode_lines("least damped modes", mode_rows(analysis.hover))
    if margins := margin_rows(analysis):
        lines += ["", f"{'stable between':<{NAME}}{'lower':>{LIMIT}}{'upper':>{LIMIT}}"]
        lines += [f"  {name:<{NAME - 2}}{low:>{LIMIT}}{up:>{LIMIT}}" for name, low, up in margins]
    if path := path_rows(analysis):
        lines += ["", *_mode_lines("along the path", path)]
    lines += [f"\nnote: {note}" for note in notes(analysis)]
    return "\n".join(line.rstrip() for line in lines)


def notes(analysis: Analysis) -> list[str]:
    """Returns notes on commands at their limits, and on a hover or a flight that is incomplete."""
    sentences = []
    if not analysis.hover.is_settled:
        sentences.append("the hover does not come to rest; it is linearised in motion, after trim")
    if names := analysis.hover.saturated:
        limits = f"commands at their limits in hover, where the loop is open: {', '.join(names)}"
        sentences.append(limits)
    return [*sentences, analysis.ended] if analysis.ended else sentences


def _mode_lines(title: str, rows: list[list[str]]) -> list[str]:
    """Returns two lines of titles, and a line for each row."""
    width = max(len(cells[4]) for cells in [*rows, [""] * 6]) + 2
    names, units = zip(*TITLES, strict=True)
    rows = [[title, *names, "motions", "systems"], ["", *units, "", ""], *rows]
    lines = []
    for label, *numbers, motions, systems in rows:
        label = label if label == title else f"  {label}"
        cells = "".join(f"{cell:>{CELL}}" for cell in numbers)
        lines.append(
            f"{label:<{NAME}}{cells}  {motions:<{max(width, len('motions') + 2)}}{systems}"
        )
    return lines


def _limit(margin: StabilityMargin, limit: StabilityLimit | None, end: float) -> str:
    """Returns a limit with its frequency; without one, the end of the search in which none is."""
    if limit is not None:
        return f"{_value(margin, limit.value)} at {limit.frequency_hz:.1f} Hz"
    side = "<" if end < margin.nominal else ">"
    return "" if end == margin.nominal else f"{side} {_value(margin, end)}"


def _value(margin: StabilityMargin, value: float) -> str:
    number = _number(margin, value)
    return f"{number} ms" if margin.kind == "delay" else f"x {number}"


def _number(margin: StabilityMargin, value: float) -> str:
    """Returns a delay in ms, or a factor, with three digits."""
    return f"{(1e3 if margin.kind == 'delay' else 1.0) * value:.3g}"

"""Table and JSON file of an analysis, and its matrices as arrays."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.margins import StabilityLimit, StabilityMargin
from aerodrake.analysis.sampled_system import SampledSystem
from aerodrake.flight.summary import rounded, to_json
from aerodrake.scenario import Scenario
from aerodrake.support.version import __version__

FILE, MATRICES = "analysis.json", "system.npz"

MOST_MODES = 8
"""Largest number of modes in a table."""
MOST_PARTICIPANTS = 4
"""Largest number of participants of a mode in a table."""

MARGINS = {"base_delay": "base delay", "rotor_gain": "rotor gain", "joint_gain": "joint gain"}
"""Labels of the margins."""

NAME, CELL, LIMIT = 24, 12, 22
"""Widths in the table."""


def least_damped(point: OperatingPoint) -> list[Eigenmode]:
    """Returns the modes of a table: those with the smallest damping ratios, the smallest first."""
    modes = sorted(point.modes, key=lambda mode: (mode.is_stable, mode.damping))
    return modes[:MOST_MODES]


def as_figures(analysis: Analysis, scenario: Scenario) -> dict[str, Any]:
    """Returns the content of `analysis.json`; numbers that are not finite are null.

    Keys:
        is_stable, sentence: Of hover and the whole path.
        period_s: s, period of the sampled system.
        hover: The loop in hover: `time_s` null, `is_stable`, `sentence`, and `modes`, the fastest
            growing first, each with its `eigenvalue` z as real and imaginary part, `growth_1_s`,
            `frequency_hz`, `damping`, `is_stable`, and `participants` with their shares.
        path: The same at each requested time.
        ended: Why the flight ended before the last requested time; empty if it did not.
        margins: By name: `kind`, the `nominal` value, the `end` of the search, and `lower` and
            `upper`, each with `value` (s, or a factor) and `frequency_hz`, or null.
        step_responses: By disturbance: `unit`, `peak`, `settling_s`, and the tool's motion
            `values` (T, 3) over `time_s` (T,).
        frequency_responses: By input: `unit`, `peak`, `peak_hz`, and `magnitude` (F,) over
            `hz` (F,).
    """
    return {
        "scenario": analysis.scenario,
        "seed": scenario.seed,
        "version": __version__,
        "is_stable": analysis.is_stable,
        "sentence": analysis.sentence,
        "period_s": analysis.hover.system.dt,
        "margins": {margin.name: _margin(margin) for margin in analysis.margins},
        "hover": _point(analysis.hover),
        "path": [_point(point) for point in analysis.path],
        "ended": analysis.ended,
        "step_responses": {
            response.input: {
                "unit": response.unit,
                "peak": rounded(response.peak),
                "settling_s": response.settling_s,
                "time_s": _numbers(response.time_s),
                "values": [_numbers(row) for row in response.values],
            }
            for response in analysis.step_responses
        },
        "frequency_responses": {
            response.input: {
                "unit": response.unit,
                "peak": rounded(response.peak),
                "peak_hz": rounded(response.peak_hz),
                "hz": _numbers(response.hz),
                "magnitude": _numbers(response.magnitude),
            }
            for response in analysis.frequency_responses
        },
    }


def _point(point: OperatingPoint) -> dict[str, Any]:
    return {
        "time_s": point.time_s,
        "is_stable": point.is_stable,
        "sentence": point.sentence,
        "modes": [_mode(mode) for mode in point.modes],
    }


def _mode(mode: Eigenmode) -> dict[str, Any]:
    return {
        "eigenvalue": [rounded(mode.eigenvalue.real), rounded(mode.eigenvalue.imag)],
        "growth_1_s": rounded(mode.growth_1_s),
        "frequency_hz": rounded(mode.frequency_hz),
        "damping": rounded(mode.damping),
        "is_stable": mode.is_stable,
        "participants": {name: rounded(share) for name, share in mode.participants},
    }


def _margin(margin: StabilityMargin) -> dict[str, Any]:
    limits = {
        side: limit and {"value": limit.value, "frequency_hz": rounded(limit.frequency_hz)}
        for side, limit in (("lower", margin.lower), ("upper", margin.upper))
    }
    return {"kind": margin.kind, "nominal": margin.nominal, "end": list(margin.end), **limits}


def _numbers(values: np.ndarray) -> list[float | None]:
    """Returns (N,) numbers for a JSON file."""
    return [rounded(value) for value in values]


def write_results(analysis: Analysis, scenario: Scenario, folder: Path) -> None:
    """Writes `analysis.json` and `system.npz` into an existing folder.

    Raises:
        OSError: if a file cannot be written.
    """
    text = to_json(as_figures(analysis, scenario))
    (folder / FILE).write_text(text, encoding="utf-8")
    np.savez_compressed(folder / MATRICES, **as_arrays(analysis.hover.system))


def as_arrays(system: SampledSystem) -> dict[str, np.ndarray]:
    """Returns the arrays of `system.npz`, as the attributes of `SampledSystem`."""
    names = ("A", "B", "C", "D", "dt", "states", "inputs", "outputs", "state_scale")
    return {name: np.array(getattr(system, name)) for name in names}


def mode_rows(modes: Sequence[Eigenmode]) -> list[list[str]]:
    """Returns number, growth, frequency, damping and participants of each mode."""
    return [
        [
            str(number),
            f"{mode.growth_1_s:+.2f}",
            f"{mode.frequency_hz:.2f}",
            f"{mode.damping:.3f}",
            ", ".join(
                f"{name} {share:.0%}" for name, share in mode.participants[:MOST_PARTICIPANTS]
            ),
        ]
        for number, mode in enumerate(modes, start=1)
    ]


def margin_rows(analysis: Analysis) -> list[list[str]]:
    """Returns label, lower and upper limit of each margin, empty where the search has no side."""
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
    if modes := least_damped(analysis.hover):
        names = ", ".join(name for name, _ in modes[0].participants[:2])
        note = f"damping ratio {modes[0].damping:.3f}: {names}"
        shown.append(("least damped", f"{modes[0].frequency_hz:.1f} Hz", note))
    if not analysis.hover.is_stable:
        return shown
    for margin in analysis.margins:
        sides = zip((margin.lower, margin.upper), margin.end, ("<", ">"), strict=True)
        limits = [
            f"{'' if limit else f'{beyond} '}{_number(margin, limit.value if limit else end)}"
            for limit, end, beyond in sides
            if end != margin.nominal
        ]
        found = [f"{limit.frequency_hz:.1f} Hz" for limit in (margin.lower, margin.upper) if limit]
        note = f"unstable beyond, at {' and '.join(found)}" if found else "stable throughout"
        unit = " ms" if margin.kind == "delay" else ""
        label = MARGINS.get(margin.name, margin.name)
        shown.append((label, f"{' to '.join(limits)}{unit}", note))
    return shown


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
    """Returns a delay in ms, or a factor, with two or three digits."""
    return f"{(1e3 if margin.kind == 'delay' else 1.0) * value:.3g}"


def path_rows(analysis: Analysis) -> list[list[str]]:
    """Returns reference time, and growth, frequency, damping and participants of its first mode."""
    return [
        [f"{point.time_s:.2f} s", *mode_rows(point.modes[:1])[0][1:]] for point in analysis.path
    ]


def analysis_table(analysis: Analysis) -> str:
    """Returns sentence, least damped modes, margins and path of an analysis as text."""
    lines = [f"{analysis.scenario}: {analysis.sentence}", ""]
    titles = ["growth, 1/s", "freq., Hz", "damping"]
    head = "".join(f"{title:>{CELL}}" for title in titles)
    lines += [f"{'least damped modes':<{NAME}}{head}  takes part"]
    lines += [
        _line(f"  {number}", cells) for number, *cells in mode_rows(least_damped(analysis.hover))
    ]
    if analysis.hover.is_stable:
        lines += ["", f"{'stable between':<{NAME}}{'lower':>{LIMIT}}{'upper':>{LIMIT}}"]
        lines += [
            f"  {label:<{NAME - 2}}{lower:>{LIMIT}}{upper:>{LIMIT}}"
            for label, lower, upper in margin_rows(analysis)
        ]
    if analysis.path:
        lines += ["", f"{'first mode of the path':<{NAME}}{head}  takes part"]
        lines += [_line(f"  {time}", cells) for time, *cells in path_rows(analysis)]
    if analysis.ended:
        lines += ["", f"note: {analysis.ended}"]
    return "\n".join(line.rstrip() for line in lines)


def _line(label: str, cells: Sequence[str]) -> str:
    *numbers, participants = cells
    return f"{label:<{NAME}}{''.join(f'{cell:>{CELL}}' for cell in numbers)}  {participants}"

"""JSON file of an analysis, and its matrices as arrays."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.margins import StabilityMargin
from aerodrake.analysis.sampled_system import SampledSystem
from aerodrake.flight.summary import rounded, to_json
from aerodrake.scenario import Scenario
from aerodrake.support.version import __version__

FILE, MATRICES = "analysis.json", "system.npz"


def as_figures(analysis: Analysis, scenario: Scenario) -> dict[str, Any]:
    """Returns the content of `analysis.json`; numbers that are not finite are null.

    Keys:
        is_stable, sentence: Of hover and the whole path.
        period_s: s, period of the sampled system.
        hover: The loop in hover: `time_s` null, `is_stable`, `sentence`, `saturated` (names of the
            joints and rotors whose command is at its limit), `is_settled` (false if it does not
            come to rest), and `modes`, the fastest growing first, each with its `eigenvalue` z as
            real and imaginary part, `growth_1_s`, `frequency_hz`, `damping`, `is_stable`, and
            `participants` with their shares.
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
        "saturated": list(point.saturated),
        "is_settled": point.is_settled,
        "modes": [_mode(mode) for mode in point.modes],
    }


def _mode(mode: Eigenmode) -> dict[str, Any]:
    return {
        "eigenvalue": [rounded(mode.eigenvalue.real), rounded(mode.eigenvalue.imag)],
        "growth_1_s": rounded(mode.growth_1_s),
        "frequency_hz": rounded(mode.frequency_hz),
        "damping": rounded(mode.damping),
        "is_stable": bool(mode.is_stable),
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
    return {field.name: np.array(getattr(system, field.name)) for field in fields(system)}

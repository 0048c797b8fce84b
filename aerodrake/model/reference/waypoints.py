"""Waypoint files, CSV with the header `t,x,y,z`, and the path through waypoints."""

import csv
import io
import reprlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.support.decimals import read_decimal
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded

MAX_FILE_BYTES = 20_000_000
"""Largest waypoint file that is read."""

MIN_STEP_S = 1e-3
"""Smallest step in time between rows."""

TIME_ROUNDING_S = 2e-5
"""Most by which rounding of times may reduce a step: in single precision up to 256 s."""

Columns = Mapping[str, tuple[str, float, float]]
"""Unit and closed range of each column, by name; the first column is time in s."""

COLUMNS: Columns = {"t": ("s", 0.0, 1e5), **dict.fromkeys("xyz", ("m", -1000.0, 1000.0))}
"""Columns of a waypoint file."""


def read_waypoints(path: str | Path, columns: Columns = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """Reads a waypoint file, or a file with other `columns`.

    The header consists of their names, in any case and spacing, and may be a comment. A byte-order
    mark, blank lines and comments, from `#` to the end of a line, are skipped. Errors number rows
    as editors do: the first line is row 1.

    Returns:
        times: (M,) s, reference times, ascending from 0 or later; M >= 2.
        points: (M, 3) the other columns; of waypoints m, in the world frame.

    Raises:
        BadInput: if the file is missing, too large or not UTF-8 text, or if it does not
            consist of two or more rows of four decimal numbers in their ranges, at least
            `MIN_STEP_S` apart in time, except for `TIME_ROUNDING_S`.
    """
    path, header = Path(path), ",".join(columns)
    content = read_bounded(path, MAX_FILE_BYTES)
    try:
        text = io.StringIO(content.decode("utf-8-sig"), newline="")
        table = np.array(list(_rows(text, path, columns)))
    except (UnicodeDecodeError, csv.Error):
        raise BadInput(path, "", "expected UTF-8 text, as comma-separated values") from None
    if len(table) < 2:
        raise BadInput(path, "", f"expected at least 2 rows {header}, got {len(table)}")
    return table[:, 0], table[:, 1:]


def interpolate_waypoints(times: np.ndarray, points: np.ndarray) -> PiecewisePolynomial:
    """Returns the path through waypoints, at rest at both ends.

    It is piecewise cubic and shape-preserving (Fritsch and Carlson 1980): velocity is
    continuous, and each axis is monotonic between waypoints, so that it neither overshoots
    nor moves between equal values. Outside `times` it stays at the first or last point.

    Args:
        times: (M,) s, ascending, M >= 2.
        points: (M, 3) m.
    """
    return PiecewisePolynomial.CubicShapePreserving(
        times, points.T, zero_end_point_derivatives=True
    )


def _rows(file: Iterator[str], path: Path, columns: Columns) -> Iterator[list[float]]:
    """Yields the checked numbers of each row."""
    expected, header = ",".join(columns), ""
    earliest = -np.inf
    reader = csv.reader(_without_comments(file, expected))
    for cells in reader:
        if not any(cell.strip() for cell in cells):
            continue
        if not header:
            header = _names(",".join(cells))
            if header != expected:
                got = reprlib.repr(header)
                place = f"row {reader.line_num}"
                raise BadInput(path, "", f"{place}: expected the header {expected}, got {got}")
            continue
        try:
            row = _numbers(cells, columns)
            if row[0] < earliest:
                raise ValueError(f"expected t to ascend by at least {MIN_STEP_S} s, got {row[0]!r}")
        except ValueError as error:
            raise BadInput(path, "", f"row {reader.line_num}: {error}") from None
        earliest = row[0] + MIN_STEP_S - TIME_ROUNDING_S
        yield row
    if not header:
        raise BadInput(path, "", f"row 1: expected the header {expected}, got an empty file")


def _without_comments(file: Iterator[str], header: str) -> Iterator[str]:
    """Yields the lines without comments; a header may be one, as `numpy.savetxt` writes it."""
    for line in file:
        text, _, comment = line.partition("#")
        yield comment if not text.strip() and _names(comment) == header else text


def _names(line: str) -> str:
    """Returns the names of a header in lower case and without spaces."""
    return ",".join(name.strip().lower() for name in line.split(","))


def _numbers(cells: list[str], columns: Columns) -> list[float]:
    """Returns the numbers in one row's cells; raises ValueError if they do not fit `columns`."""
    if len(cells) != len(columns):
        raise ValueError(f"expected {len(columns)} cells, got {len(cells)}")
    row = []
    for cell, (name, (unit, low, high)) in zip(cells, columns.items(), strict=True):
        number = read_decimal(cell.strip())
        if not low <= number <= high:
            expected = f"expected {name} in [{low:g}, {high:g}] {unit} as a decimal number"
            raise ValueError(f"{expected}, got {reprlib.repr(cell)}")
        row.append(number)
    return row

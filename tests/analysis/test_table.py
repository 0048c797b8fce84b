"""Table of an analysis."""

from dataclasses import replace

from aerodrake.analysis.table import (
    analysis_table,
    highlights,
    margin_rows,
    mode_row,
    mode_rows,
)
from tests.analyses import made, mode, point


def test_the_rows_are_of_the_least_damped_modes():
    """The stiff joint has decayed after a period."""
    assert mode_rows(point(0.5)) == [
        ["1", "+0.50", "9.60", "-0.008", "roll 70 %, joint_2 30 %", ""],
        ["2", "-3.00", "0.40", "0.767", "x 100 %", ""],
        ["3", "-10.00", "0.00", "1.000", "", "controller 100 %"],
    ]
    assert mode_row(point(0.5), mode(-40.0, 0.0))[2:] == ["1.000", "", ""]


def test_margins_without_a_limit_show_the_end_of_the_search():
    assert margin_rows(made()) == [
        ["base delay", "", "22 ms at 5.1 Hz"],
        ["rotor gain", "x 0.31 at 0.9 Hz", "> x 5"],
        ["joint gain", "< x 0.1", "x 2.4 at 14.2 Hz"],
    ]


def test_the_table_has_modes_margins_and_path():
    lines = analysis_table(made(times=(0.5, 4.0))).splitlines()
    assert lines[0].startswith("made: unstable at 4.00 s")
    assert any(
        line.split() == ["joint", "gain", "<", "x", "0.1", "x", "2.4", "at", "14.2", "Hz"]
        for line in lines
    )
    assert lines[-1].split()[:3] == ["4.00", "s", "+1.50"]
    assert max(map(len, lines)) <= 100
    assert "stable between" not in analysis_table(made(0.5))


def test_commands_at_their_limits_are_noted():
    analysis = made()
    analysis = replace(analysis, hover=replace(analysis.hover, saturated=("elbow",)), ended="end")
    assert analysis_table(analysis).splitlines()[-3:] == [
        "note: commands at their limits in hover, where the loop is open: elbow",
        "",
        "note: end",
    ]


def test_the_highlights_are_the_margins_of_a_stable_hover():
    assert highlights(made()) == [
        ("least damped", "9.6 Hz", "damping ratio 0.033"),
        ("base delay", "22 ms", "unstable beyond, at 5.1 Hz"),
        ("rotor gain", "0.31 to > 5", "unstable beyond, at 0.9 Hz"),
        ("joint gain", "< 0.1 to 2.4", "unstable beyond, at 14.2 Hz"),
    ]
    assert len(highlights(made(0.5))) == 1

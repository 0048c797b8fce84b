"""Table, JSON and arrays of an analysis."""

import json

import numpy as np
import pytest
from scipy.signal import StateSpace

from aerodrake.analysis.report import (
    FILE,
    MATRICES,
    analysis_table,
    least_damped,
    margin_rows,
    mode_rows,
    write_results,
)
from aerodrake.scenario import Scenario
from tests.analyses import made, mode, point


def test_the_least_damped_modes_are_the_unstable_ones_first():
    hover = point(0.5)
    assert [mode.participants[0].name for mode in least_damped(hover)] == [
        "roll",
        "x",
        "controller",
    ]
    assert mode_rows([hover.modes[0]]) == [
        ["1", "+0.50", "9.60", "-0.008", "roll 70%, joint_2 30%"]
    ]
    assert mode_rows([mode(-40.0, 0.0)])[0][3:] == ["1.000", ""]


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


def test_the_files_have_the_whole_analysis(tmp_path):
    analysis = made(times=(4.0,))
    write_results(analysis, Scenario(seed=3), tmp_path)
    figures = json.loads((tmp_path / FILE).read_text())
    assert figures["seed"] == 3 and not figures["is_stable"] and figures["hover"]["is_stable"]
    assert figures["sentence"] == analysis.sentence
    assert figures["margins"]["base_delay"]["upper"] == {"value": 0.022, "frequency_hz": 5.13}
    assert figures["margins"]["base_delay"]["lower"] is None
    first = figures["hover"]["modes"][0]
    assert first["participants"] == {"roll": 0.7, "joint_2": 0.3}
    assert complex(*first["eigenvalue"]) == pytest.approx(analysis.hover.modes[0].eigenvalue)
    assert len(figures["step_responses"]["force_x"]["values"]) == 101
    assert figures["frequency_responses"]["torque"]["peak"] == 3e-3
    assert [point["time_s"] for point in figures["path"]] == [4.0]


def test_the_matrices_make_a_state_space_without_pickles(tmp_path):
    analysis = made()
    write_results(analysis, Scenario(), tmp_path)
    with np.load(tmp_path / MATRICES, allow_pickle=False) as arrays:
        system = StateSpace(*(arrays[name] for name in "ABCD"), dt=arrays["dt"].item())
        assert arrays["states"][0] == "plant.roll" and arrays["inputs"].tolist() == ["force_x"]
    np.testing.assert_array_equal(system.A, analysis.hover.system.A)

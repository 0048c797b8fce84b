"""JSON and arrays of an analysis."""

import json

import numpy as np
import pytest
from scipy.signal import StateSpace

from aerodrake.analysis.results import FILE, MATRICES, write_results
from aerodrake.scenario import Scenario
from tests.analyses import made


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

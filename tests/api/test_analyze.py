"""`aerodrake.analyze` and its result."""

import json

import pytest

import aerodrake
from aerodrake.api import analyze as module
from tests.analyses import made


@pytest.fixture
def analysed(monkeypatch):
    """The arguments of each analysis; its result is made up."""
    calls = []

    def analyze_loop(scenario, times, progress):
        calls.append((scenario.name, list(times)))
        progress("hover")
        return made(times=tuple(times))

    monkeypatch.setattr(module, "analyze_loop", analyze_loop)
    return calls


def test_the_result_has_system_modes_margins_and_responses(analysed):
    result = aerodrake.analyze("hover", {"seed": 3}, times=2, quiet=True)
    assert analysed == [("hover", [2])]
    assert result.is_stable and result.path[0].time_s == 2 and result.scenario.seed == 3
    assert result.modes[0].frequency_hz == 9.6
    assert result.system.state_space.dt == 0.02
    assert result.margins["base_delay"].upper.value == 0.022
    assert result.step_responses["force_x"].peak == result.frequency_responses["force"].peak
    assert str(result).startswith(f"made: {result.sentence}\n") and result.sentence in repr(result)
    assert "<svg" in result._repr_html_()


def test_a_saved_analysis_is_complete(analysed, tmp_path):
    result = aerodrake.analyze("hover", times=[1, 2.5], quiet=True)
    folder = result.save(tmp_path / "analysis")
    page = result.report(folder).read_text()
    assert f"aerodrake analyze {folder}/scenario.yaml --at 1 2.5" in page
    assert json.loads((folder / "analysis.json").read_text())["scenario"] == "made"
    names = ["analysis.json", "analysis.png", "report.html", "scenario.yaml", "system.npz"]
    assert sorted(path.name for path in folder.iterdir()) == names
    result.save(folder)  # Replaces it.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"times": "3"}, "analyze: times: expected float or Sequence, got '3'"),
        ({"times": [float("nan")]}, "analyze: times: expected float or Sequence"),
        ({"mpc.horizon": 0}, "hover: mpc.horizon: expected a whole number"),
    ],
)
def test_bad_input_names_the_argument(arguments, message, analysed):
    with pytest.raises(aerodrake.BadInput, match=message):
        aerodrake.analyze("hover", quiet=True, **arguments)

"""Files, output and exit codes of `aerodrake analyze`."""

import pytest

from aerodrake.api import analyze as module
from aerodrake.cli import main
from tests.analyses import made

FILES = ["analysis.json", "analysis.png", "report.html", "scenario.yaml", "system.npz"]


@pytest.fixture
def analysed(monkeypatch):
    """Calls of `analyze_loop`, whose path is unstable after 3 s."""
    calls = []

    def analyze_loop(scenario, times, progress):
        calls.append((scenario.mpc.horizon, *times))
        return made(times=tuple(times))

    monkeypatch.setattr(module, "analyze_loop", analyze_loop)
    monkeypatch.setattr("aerodrake.analysis.folder.plot_analysis", lambda _, path: path.touch())
    monkeypatch.setattr("aerodrake.analysis.page._pictures", lambda *_: [])
    return calls


def test_files_output_and_exit_code(analysed, tmp_path, capsys):
    command = ["analyze", "hover", "--set", "mpc.horizon=9", "--out", str(tmp_path / "a")]
    assert main([*command, "--at", "1", "2"]) == 0
    output, errors = capsys.readouterr()
    assert "made: stable in hover" in output and "analyze hover" in errors
    assert output.rstrip().endswith("scenario.yaml, analysis.png, report.html")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == FILES
    assert main([*command, "--at", "4", "--at", "1", "--quiet"]) == 1  # Unstable.
    assert capsys.readouterr() == ("", "")
    assert analysed == [(9, 1.0, 2.0), (9, 4.0, 1.0)]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["hover", "--at", "99"], "aerodrake: --at: expected times in [0, 10] s, got 99"),
        (["clovr"], "did you mean 'clover'?"),
        (["hover", "--set", "arm.bandwith_rad_s=3"], "did you mean 'bandwidth_rad_s'"),
        (["hover", "--out", "file"], "file: expected a folder"),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(
    options, expected, analysed, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("precious")
    assert main(["analyze", *options]) == 2
    out, error = capsys.readouterr()
    assert out == "" and expected in error and len(error.splitlines()) == 1
    assert [path.name for path in tmp_path.rglob("*")] == ["file"]


def test_times_are_numbers(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["analyze", "hover", "--at", "soon"])
    assert "--at: expected a number in [0, 3600], got 'soon'" in capsys.readouterr().err

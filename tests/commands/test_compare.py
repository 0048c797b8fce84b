"""Files, output and exit codes of `aerodrake compare`."""

import json
import re

import pytest

from aerodrake.cli import main
from aerodrake.comparison import compare as module
from aerodrake.comparison.compare import VARIANTS
from aerodrake.flight.summary import repeatable
from tests.in_this_process import in_this_process

SHORT = ["--set", "duration=0.3", "--set", "settle_s=0.1"]


def test_files_and_output_are_reproducible(tmp_path, monkeypatch, capfd):
    two = {name: VARIANTS[name] for name in ("integral", "modified+online")}
    monkeypatch.setattr(module, "VARIANTS", two)
    untrained = ["--set", "residual.checkpoint=''"]
    command = ["compare", "clover_paper", *SHORT, *untrained, "--jobs", "2"]
    assert main([*command, "--out", str(tmp_path / "a")]) == 0
    output, progress = capfd.readouterr()
    assert "note: residual.checkpoint names no network" in output
    assert re.search(r"^integral +\d", output, re.MULTILINE)
    assert re.search(r"^modified\+online +\d.* -?\+?\d+\.\d %.* completed$", output, re.MULTILINE)
    assert "paper: " not in output  # Its results are of whole laps.
    assert "2/2" in progress
    written = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert written == [
        *("comparison.json", "comparison.png", "integral", "modified+online", "report.html"),
        "scenario.yaml",
    ]

    def read():
        comparison = json.loads((tmp_path / "a" / "comparison.json").read_text())
        assert comparison["scenario"] == "clover_paper" and list(comparison["variants"]) == list(
            two
        )
        figures = {name: repeatable(s) for name, s in comparison["variants"].items()}
        return figures, (tmp_path / "a" / "comparison.png").read_bytes()

    first = read()
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    # Only the figure of the comparison is compared.
    monkeypatch.setattr("aerodrake.reports.flight_folder.plot_tracking", lambda *_: None)
    monkeypatch.setattr("aerodrake.comparison.page._pictures", lambda *_: [])
    assert main([*command, "--quiet", "--out", str(tmp_path / "a")]) == 0
    assert capfd.readouterr() == ("", "")
    assert read() == first


@pytest.mark.usefixtures("undrawn")
def test_only_the_given_variants_are_flown(tmp_path, monkeypatch, capsys):
    """Variants that are not given may be invalid: `allocation.k_m=0` is for `clik`."""
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    flown = ["--variant", "fixed_weights", "--variant", "integral", "--variant", "integral"]
    settings = ["--set", "duration=0.1", "--set", "settle_s=0", "--set", "allocation.k_m=0"]
    out = tmp_path / "out"
    assert main(["compare", "hover", *settings, *flown, "--out", str(out)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^integral +0.00", output, re.MULTILINE) and "modified " not in output
    variants = json.loads((out / "comparison.json").read_text())["variants"]
    assert list(variants) == ["integral", "fixed_weights"]
    assert sorted(path.name for path in out.iterdir()) == [
        *("comparison.json", "comparison.png", "fixed_weights", "integral", "report.html"),
        "scenario.yaml",
    ]


@pytest.mark.usefixtures("undrawn")
def test_a_lost_variant_is_a_success(tmp_path, monkeypatch, capsys):
    """The vehicle falls, since its rotors are too weak."""
    monkeypatch.setattr(module, "VARIANTS", {"modified": VARIANTS["modified"]})
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    weak = ["--set", "vehicle.rotor.max_thrust_n=2", "--set", "vehicle.base_position_m=[0, 0, 9]"]
    fall = [*weak, "--set", "duration=1", "--set", "settle_s=0"]
    assert main(["compare", "hover", *fall, "--out", str(tmp_path / "out")]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^modified +\d.*  lost: .+ at 0\.\d+ s$", output, re.MULTILINE)


@pytest.mark.usefixtures("undrawn")
def test_a_failed_variant_is_a_failure(tmp_path, monkeypatch, capsys):
    """Its cause is printed, and the other variants are written."""
    fly = module._fly

    def fail_one(flight):
        if flight[1].name == "clik":
            raise RuntimeError("out of luck")
        return fly(flight)

    monkeypatch.setattr(module, "VARIANTS", {n: VARIANTS[n] for n in ("modified", "clik")})
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    monkeypatch.setattr(module, "_fly", fail_one)
    out = tmp_path / "out"
    command = ["compare", "hover", "--set", "duration=0.1", "--set", "settle_s=0"]
    assert main([*command, "--out", str(out)]) == 1
    output = capsys.readouterr().out
    assert re.search(r"^clik +failed: RuntimeError: out of luck$", output, re.MULTILINE)
    assert re.search(r"^modified +0.000 .* completed$", output, re.MULTILINE)
    variants = json.loads((out / "comparison.json").read_text())["variants"]
    assert variants["clik"] == {"exit_reason": "failed", "exit_cause": "RuntimeError: out of luck"}
    assert variants["modified"]["exit_reason"] == "completed"


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["clovr"], "did you mean 'clover'?"),
        (["hover", "--variant", "clic"], "variants: no such variant 'clic'; did you mean 'clik'?"),
        (["hover", "--margins", "--variant", "clic"], "did you mean 'clik'?"),
        (["hover", "--set", "controler=clik"], "--set: controler: unknown key"),
        (["hover", "--set", "controller=pid"], "controller: unknown value 'pid'"),
        (["hover", "--set", "allocation.kind=none"], "allocation.kind: unknown value"),
        (["hover", "--set", "allocation.fixed_gamma=2"], "allocation.fixed_gamma: expected a num"),
        (["hover", "--set", "clik.damping=0"], "clik.damping: expected a number in [0.0001, 10]"),
        (["hover", "--baseline", "none.yaml"], "none.yaml: expected a readable file"),
        (["hover", "--baseline", "mine/comparison.json"], "expected a mapping of keys to values"),
        (["hover", "--set", "baseline.w_4=[1]"], "baseline: removed; put its keys in a file"),
        (
            ["hover", "--set", "allocation.k_m=0"],
            "hover.yaml --set allocation.k_m=0 as clik: alloc",
        ),
        (["hover", "--set", "residual.checkpoint=none.pt"], "none.pt: "),
        (["hover", "--set", "vehicle.robot=none.urdf"], "none.urdf: "),
        (["hover", "--out", "file"], "file: expected a folder"),
        (["hover", "--out", "mine"], "mine: holds files that are not of"),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(
    options, expected, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "run_parallel", lambda *_: pytest.fail("flown"))
    (tmp_path / "file").write_text("precious")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "comparison.json").write_text("precious")
    assert main(["compare", *options]) == 2
    out, error = capsys.readouterr()
    assert out == "" or out.startswith("note: ")
    assert expected in error and len(error.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["comparison.json", "file", "mine"]


@pytest.mark.parametrize("jobs", ["0", "-1", "x", "1.5", "1e9"])
def test_jobs_are_whole_numbers_from_one(jobs, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["compare", "hover", "--jobs", jobs])
    assert "--jobs: expected a whole number in [1, 1000]" in capsys.readouterr().err


def test_an_interrupted_comparison_writes_nothing(tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "run_parallel", interrupt)
    assert main(["compare", "hover", "--quiet", "--out", str(tmp_path / "out")]) == 130
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr().err == "aerodrake: interrupted\n"

"""Variants of a scenario, and what a comparison leaves behind."""

import dataclasses
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from aerodrake import compare as module
from aerodrake.cli import main
from aerodrake.compare import OWN_VARIANT, VARIANTS, compare, make_variants, notes
from aerodrake.errors import BadInput
from aerodrake.flight_log import FlightLog
from aerodrake.scenario import Model, Scenario
from aerodrake.scenario_file import load_scenario
from aerodrake.schema import as_mapping

SHORT = [("--set", "duration=0.3"), ("--set", "settle_s=0.1")]


def differences(a: Scenario, b: Scenario) -> dict[str, tuple[object, object]]:
    """{section.key: (in a, in b)} where they differ."""

    def flat(data, prefix=""):
        for key, value in data.items():
            if isinstance(value, dict):
                yield from flat(value, f"{prefix}{key}.")
            else:
                yield f"{prefix}{key}", value

    ours, theirs = (dict(flat(as_mapping(s))) for s in (a, b))
    return {key: (ours[key], theirs[key]) for key in ours if ours[key] != theirs[key]}


@pytest.fixture
def paper() -> Scenario:
    return load_scenario("clover_paper", SHORT)


def test_variants_differ_from_the_scenario_in_what_they_are_named_after(paper):
    """In nothing else: not in a gain, a bound, the seed or the reference."""
    variants = make_variants(paper)
    assert list(variants) == [
        "integral", "integral_best", "modified", "modified+offline", "modified+online", "clik",
        "fixed_weights",
    ]  # fmt: skip
    off = {"residual.mode": ("online", "off")}
    integral = {"model.kind": ("paper", "integral")} | off
    changes = {name: differences(paper, variant) for name, variant in variants.items()}
    weights = {key: change for key, change in changes["integral_best"].items() if "mpc.w_" in key}
    assert changes.pop("integral_best") == integral | weights and weights
    assert changes == {
        "integral": integral,
        "modified": off,
        "modified+offline": {"residual.mode": ("online", "offline")},
        "modified+online": {},
        "clik": {"controller": ("mpc", "clik")} | off,
        "fixed_weights": {"allocation.kind": ("gamma", "fixed")},
    }


def test_the_integral_model_at_its_best_has_the_weights_of_the_baseline(paper):
    own = replace(paper.baseline, w_1=(1.0, 2.0, 3.0), w_3_joints=(5.0,))
    mpc = make_variants(replace(paper, baseline=own))["integral_best"].mpc
    for field in dataclasses.fields(own):
        assert getattr(mpc, field.name) == getattr(own, field.name)
    assert replace(
        mpc, **{f.name: getattr(paper.mpc, f.name) for f in dataclasses.fields(own)}
    ) == (paper.mpc)


@pytest.mark.parametrize(("name", "kind"), [("clover", "flight"), ("clover_paper", "paper")])
def test_a_scenario_that_is_a_baseline_itself_is_compared_all_the_same(name, kind):
    """With its interface's own model, by the MPC, with allocation."""
    scenario = load_scenario(name, SHORT)
    baseline = replace(
        scenario,
        controller="clik",
        model=replace(scenario.model, kind="integral"),
        allocation=replace(scenario.allocation, kind="fixed"),
    )
    assert make_variants(baseline) == make_variants(scenario)
    assert make_variants(scenario)["modified"].model == Model(kind, scenario.model.k_b)


@pytest.mark.parametrize("mode", ["off", "offline", "online"])
def test_own_variant_is_the_scenario(mode, paper):
    own = replace(paper, residual=replace(paper.residual, mode=mode))
    assert make_variants(own)[OWN_VARIANT[mode]] == own


def test_a_network_that_is_none_is_noted(paper):
    assert notes(paper) == []
    untrained = replace(paper, residual=replace(paper.residual, checkpoint=""))
    (note,) = notes(untrained)
    assert "modified+offline is the same as modified" in note


def test_baseline_weights_of_another_arm_are_named(paper):
    wrong = replace(paper, baseline=replace(paper.baseline, w_3_joints=(1.0, 2.0)))
    with pytest.raises(BadInput, match="baseline.w_3_joints: expected 1 value, or 6"):
        make_variants(wrong)


# Flown, in processes.


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """(scenario, folder, summaries) of all variants, 0.3 s each."""
    scenario = load_scenario("clover_paper", SHORT)
    folder = tmp_path_factory.mktemp("comparison")
    names = ("modified", "clik", "fixed_weights")
    variants = {name: make_variants(scenario)[name] for name in names}
    return scenario, folder, compare(variants, folder, jobs=2)


def repeatable(figures: dict) -> dict:
    """A summary without its wall times."""
    mpc = {k: v for k, v in figures["mpc"].items() if k not in ("median_ms", "p99_ms", "overruns")}
    rest = {k: v for k, v in figures.items() if k not in ("wall_s", "real_time_factor")}
    return rest | {"mpc": mpc}


def test_each_variant_has_the_folder_of_a_run(flown):
    _, folder, summaries = flown
    assert list(summaries) == ["modified", "clik", "fixed_weights"]
    for name, summary in summaries.items():
        assert summary["exit_reason"] == "completed"
        assert json.loads((folder / name / "summary.json").read_text()) == summary
        log = FlightLog.read(folder / name / "log.npz", summary)
        assert len(log.time_s) == 41 and log.exit_reason == "completed"
        assert (folder / name / "tracking.png").exists()


def test_a_variant_flies_again_by_itself(flown, tmp_path):
    _, folder, summaries = flown
    scenario, out = folder / "clik" / "scenario.yaml", tmp_path / "again"
    assert main(["run", str(scenario), "--quiet", "--out", str(out)]) == 0
    again = json.loads((out / "summary.json").read_text())
    assert repeatable(again) == repeatable(summaries["clik"])


def test_summaries_say_where_the_arm_was(flown):
    scenario, folder, summaries = flown
    for name, summary in summaries.items():
        log = FlightLog.read(folder / name / "log.npz", summary)
        d_o = np.linalg.norm(log.p_EB_m - log.p_EB_m[0], axis=1)
        assert summary["arm"]["farthest_d_o_m"] == pytest.approx(d_o.max(), abs=1e-9)
        assert summary["arm"]["outside_s"] == 0
        assert 0.1 < summary["arm"]["least_room_rad"] < 1.6


def test_a_variant_that_raises_or_dies_is_a_row_and_no_folder(monkeypatch, tmp_path, paper):
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    monkeypatch.setattr(module, "_fly", fail_or_lose)
    variants = dict.fromkeys(("integral", "modified", "clik"), paper)
    seen = []
    summaries = compare(variants, tmp_path, 2, seen.append)
    assert list(summaries) == list(variants) and seen == ["clik", "modified", "integral"]
    assert summaries["integral"] == {"exit_reason": "lost", "exit_cause": "tilt"}
    assert summaries["clik"] == {
        "exit_reason": "failed",
        "exit_cause": "RuntimeError: first line",
    }
    assert summaries["modified"] == {"exit_reason": "failed", "exit_cause": "MemoryError"}
    assert [path.name for path in tmp_path.iterdir()] == ["integral"]


def in_this_process(function, items, jobs):
    """As `run_parallel`, last first."""
    for index in reversed(range(len(items))):
        try:
            yield index, function(items[index])
        except Exception as error:
            yield index, error


def fail_or_lose(flight):
    _, folder = flight
    folder.mkdir()
    if folder.name == "clik":
        raise RuntimeError("first line\nsecond line")
    if folder.name == "modified":
        raise MemoryError
    return {"exit_reason": "lost", "exit_cause": "tilt"}


# The command.


def test_the_command(tmp_path, monkeypatch, capfd):
    """Writes and says what it should, twice the same."""
    two = {name: VARIANTS[name] for name in ("integral", "modified+online")}
    monkeypatch.setattr(module, "VARIANTS", two)
    settings = [word for pair in SHORT for word in pair] + ["--set", "residual.checkpoint=''"]
    command = ["compare", "clover_paper", *settings, "--jobs", "2"]
    assert main([*command, "--out", str(tmp_path / "a")]) == 0
    said, progress = capfd.readouterr()
    assert "note: residual.checkpoint names no network" in said
    assert re.search(r"^integral +\d", said, re.MULTILINE)
    assert re.search(r"^modified\+online +\d.* -?\+?\d+\.\d %.* completed$", said, re.MULTILINE)
    assert re.search(r"^paper: proposed +12.20|^paper: proposed", said, re.MULTILINE)
    assert "2/2" in progress
    written = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert written == [
        *("comparison.json", "comparison.png", "integral", "modified+online", "report.html")
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
    assert main([*command, "--quiet", "--out", str(tmp_path / "a")]) == 0
    assert capfd.readouterr() == ("", "")
    assert read() == first


def test_variants_that_are_not_asked_for_are_not_flown(tmp_path, monkeypatch, capsys):
    """Not even the scenario's own, and none of them need be fit to be flown."""
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    flown = ["--variant", "fixed_weights", "--variant", "integral", "--variant", "integral"]
    settings = ["--set", "duration=0.1", "--set", "settle_s=0", "--set", "allocation.k_m=0"]
    out = tmp_path / "out"
    assert main(["compare", "hover", *settings, *flown, "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^integral +0.00", said, re.MULTILINE) and "modified " not in said
    variants = json.loads((out / "comparison.json").read_text())["variants"]
    assert list(variants) == ["integral", "fixed_weights"]
    assert sorted(path.name for path in out.iterdir()) == [
        *("comparison.json", "comparison.png", "fixed_weights", "integral", "report.html")
    ]


def test_lost_is_an_ending(tmp_path, monkeypatch, capsys):
    """Rotors that do not carry it: it falls, in every variant."""
    monkeypatch.setattr(module, "VARIANTS", {"modified": VARIANTS["modified"]})
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    weak = ["--set", "vehicle.rotor.max_thrust_n=2", "--set", "vehicle.base_position_m=[0, 0, 9]"]
    fall = [*weak, "--set", "duration=1", "--set", "settle_s=0"]
    assert main(["compare", "hover", *fall, "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^modified +\d.*  lost: .+ at 0\.\d+ s$", said, re.MULTILINE)


def test_failed_is_none(tmp_path, monkeypatch, capsys):
    """It is shown, and the others are there."""
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
    said = capsys.readouterr().out
    assert re.search(r"^clik +failed: RuntimeError: out of luck$", said, re.MULTILINE)
    assert re.search(r"^modified +0.00 .* completed$", said, re.MULTILINE)
    variants = json.loads((out / "comparison.json").read_text())["variants"]
    assert variants["clik"] == {"exit_reason": "failed", "exit_cause": "RuntimeError: out of luck"}
    assert variants["modified"]["exit_reason"] == "completed"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["clovr"], "did you mean 'clover'?"),
        (["hover", "--variant", "clic"], "--variant: no such variant 'clic'; did you mean 'clik'?"),
        (["hover", "--margins", "--variant", "clic"], "did you mean 'clik'?"),
        (["hover", "--set", "controler=clik"], "--set: controler: unknown key"),
        (["hover", "--set", "controller=pid"], "controller: unknown value 'pid'"),
        (["hover", "--set", "allocation.kind=none"], "allocation.kind: unknown value"),
        (["hover", "--set", "allocation.fixed_gamma=2"], "allocation.fixed_gamma: expected a num"),
        (["hover", "--set", "clik.damping=0"], "clik.damping: expected a number in [0.0001, 10]"),
        (["hover", "--set", "baseline.w_4=[1]"], "baseline.w_4: expected a list of 3 numbers"),
        (["hover", "--set", "baseline.w_2_joints=[]"], "baseline.w_2_joints: expected 1 value"),
        (
            ["hover", "--set", "allocation.k_m=0"],
            "hover.yaml --set allocation.k_m=0 as clik: alloc",
        ),
        (["hover", "--set", "residual.checkpoint=none.pt"], "none.pt: "),
        (["hover", "--set", "vehicle.robot=none.urdf"], "none.urdf: "),
        (["hover", "--out", "file"], "--out: expected a folder"),
        (["hover", "--out", "mine"], "mine holds files that are not of an earlier run"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(options, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "run_parallel", lambda *_: pytest.fail("flown"))
    (tmp_path / "file").write_text("precious")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "comparison.json").write_text("precious")
    assert main(["compare", *options]) == 2
    out, error = capsys.readouterr()
    assert out == "" or out.startswith("note: ")
    assert said in error and len(error.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["comparison.json", "file", "mine"]


@pytest.mark.parametrize("jobs", ["0", "-1", "x", "1.5", "1e9"])
def test_jobs_are_counted_from_one(jobs, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["compare", "hover", "--jobs", jobs])
    assert "--jobs: expected a whole number in [1, 1000]" in capsys.readouterr().err


def test_an_interrupted_comparison_leaves_nothing(tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "run_parallel", interrupt)
    assert main(["compare", "hover", "--quiet", "--out", str(tmp_path / "out")]) == 130
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr().err == "aerodrake: interrupted\n"

"""Variants of a scenario, and how they are flown."""

import dataclasses
import json
from dataclasses import replace

import numpy as np
import pytest

from aerodrake.cli import main
from aerodrake.comparison import compare as module
from aerodrake.comparison.compare import (
    comparison_notes,
    fly_variants,
    load_baseline,
    make_variant,
    make_variants,
    own_variant,
    result_notes,
)
from aerodrake.flight.log import FlightLog
from aerodrake.flight.summary import repeatable
from aerodrake.scenario import Model, Residual, Scenario, Weights
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.scenario.schema import as_mapping, flat
from aerodrake.support.errors import BadInput
from tests.in_this_process import in_this_process
from tests.modules import PACKAGE

SHORT = {"duration": 0.3, "settle_s": 0.1}


def differences(a: Scenario, b: Scenario) -> dict[str, tuple[object, object]]:
    """{section.key: (in a, in b)} where they differ."""

    ours, theirs = (flat(as_mapping(s)) for s in (a, b))
    return {key: (ours[key], theirs[key]) for key in ours if ours[key] != theirs[key]}


@pytest.fixture
def paper() -> Scenario:
    return load_scenario("clover_paper", SHORT)


def test_variants_differ_from_the_scenario_only_as_their_names_state(paper):
    """All other keys are equal: gains, bounds, the seed, the reference."""
    variants = make_variants(paper)
    assert list(variants) == [
        "integral", "integral_best", "modified", "modified+offline", "modified+online",
        "modified+printed", "clik", "fixed_weights",
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
        "modified+printed": {"residual.as_printed": (False, True)},
        "clik": {"controller": ("mpc", "clik")} | off,
        "fixed_weights": {"allocation.kind": ("gamma", "fixed")},
    }


def test_the_models_with_k_b_do_not_use_a_network_for_the_flight_model():
    residual = Residual(mode="online", checkpoint="flight.pt")
    variant = make_variant(Scenario(residual=residual), "no_flight_model", Weights())
    assert variant.model.kind == "velocity_aware"
    assert (variant.residual.mode, variant.residual.checkpoint) == ("online", "")


def test_integral_best_has_the_weights_of_the_baseline(paper):
    baseline = Weights(k_e=(2.0, 3.0, 4.0), w_1=(1.0, 2.0, 3.0), w_3_joints=(5.0,))
    mpc = make_variants(paper, baseline=baseline)["integral_best"].mpc
    for field in dataclasses.fields(baseline):
        assert getattr(mpc, field.name) == getattr(baseline, field.name)
    assert replace(
        mpc, **{f.name: getattr(paper.mpc, f.name) for f in dataclasses.fields(baseline)}
    ) == (paper.mpc)


def test_integral_best_has_the_weights_packaged_for_the_scenario(paper):
    mpc = make_variants(paper)["integral_best"].mpc
    assert mpc.k_e == (0.8, 1.2, 1.2) and mpc.w_4 == (295.0, 295.0, 295.0)
    assert mpc.w_1 == Weights().w_1


@pytest.mark.parametrize(("name", "kind"), [("clover", "flight"), ("clover_paper", "paper")])
def test_variants_of_a_scenario_without_the_method_are_the_same(name, kind):
    """They have the model of the flight interface, the MPC and weight allocation."""
    scenario = load_scenario(name, SHORT)
    without = replace(
        scenario,
        controller="clik",
        model=replace(scenario.model, kind="integral"),
        allocation=replace(scenario.allocation, kind="fixed"),
    )
    assert make_variants(without) == make_variants(scenario)
    assert make_variants(scenario)["modified"].model == Model(kind, scenario.model.k_b)


@pytest.mark.parametrize(
    ("mode", "as_printed"),
    [("off", False), ("offline", False), ("offline", True), ("online", False), ("online", True)],
)
def test_own_variant_is_the_scenario(mode, as_printed, paper):
    residual = replace(paper.residual, mode=mode, as_printed=as_printed)
    own = replace(paper, residual=residual)
    assert make_variants(own)[own_variant(own)] == own


def test_the_printed_form_is_compared_if_the_scenario_learns_online(paper):
    assert "modified+printed" not in make_variants(load_scenario("clover", SHORT))
    offline = replace(paper, residual=replace(paper.residual, mode="offline"))
    assert "modified+printed" not in make_variants(offline)
    assert "modified+printed" in make_variants(offline, ["modified+printed"])


def test_a_missing_network_is_noted(paper):
    assert comparison_notes(paper) == []
    untrained = replace(paper, residual=replace(paper.residual, checkpoint=""))
    (note,) = comparison_notes(untrained)
    assert "modified+offline is the same as modified" in note


def test_notes_on_results_name_their_variant():
    residual = {"learning_rate": 0.0015, "stable_learning_rate": 0.0003}
    stable = residual | {"stable_learning_rate": 0.002}
    summaries = {
        "modified+online": {"residual": residual},
        "modified+printed": {"residual": stable},
        "clik": {"exit_reason": "failed", "exit_cause": "MemoryError"},
    }
    (note,) = result_notes(summaries)
    assert note.startswith("modified+online: residual.learning_rate 0.0015 exceeds 0.0003")


def test_baseline_weights_of_another_arm_are_refused(paper):
    with pytest.raises(BadInput, match="as integral_best: mpc.w_3_joints: expected 1 value, or 6"):
        make_variants(paper, baseline=Weights(w_3_joints=(1.0, 2.0)))


# Baselines.

PACKAGED = sorted((PACKAGE / "scenarios" / "baselines").iterdir())


@pytest.mark.parametrize("path", PACKAGED, ids=lambda path: path.stem)
def test_packaged_baselines_belong_to_packaged_scenarios(path):
    assert path.stem in packaged_scenarios() and path.suffix == ".yaml"
    scenario = load_scenario(path.stem)
    assert load_baseline(scenario) == load_baseline(scenario, path) != Weights()


def test_baselines_are_no_scenarios():
    assert "baselines" not in packaged_scenarios() and len(PACKAGED) == 3


def test_a_scenario_without_a_baseline_has_the_default_weights():
    assert load_baseline(load_scenario("hover")) == Weights()


def test_a_file_replaces_the_packaged_baseline(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("k_e: [1.0, 2.0, 3.0]")
    assert load_baseline(load_scenario("clover_paper"), path) == Weights(k_e=(1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("w_4: [1]", "w_4: expected a list of 3 numbers"),
        ("w_7: [1]", "w_7: unknown key"),
        ("w_2_joints: [-1]", "w_2_joints.0.: expected a number in"),
        ("", "expected a mapping of keys to values"),
        ("baseline: {k_e: [1, 1, 1]}", "baseline: removed; put its keys in a file"),
    ],
)
def test_an_invalid_file_is_refused(text, message, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match=f"mine.yaml: {message}"):
        load_baseline(load_scenario("hover"), path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(BadInput, match="none.yaml: expected a readable file"):
        load_baseline(load_scenario("hover"), tmp_path / "none.yaml")


# Flights.


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """(scenario, folder, summaries) of some variants, 0.3 s each."""
    scenario = load_scenario("clover_paper", SHORT)
    folder = tmp_path_factory.mktemp("comparison")
    names = ("modified", "clik", "fixed_weights")
    variants = {name: make_variants(scenario)[name] for name in names}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "run_parallel", in_this_process)
        return scenario, folder, fly_variants(variants, folder, jobs=2)


def test_each_variant_writes_the_folder_of_a_run(flown, vehicle):
    _, folder, summaries = flown
    assert list(summaries) == ["modified", "clik", "fixed_weights"]
    for name, summary in summaries.items():
        assert summary["exit_reason"] == "completed"
        assert json.loads((folder / name / "summary.json").read_text()) == summary
        log = FlightLog.read(folder / name / "log.npz", summary, vehicle)
        assert len(log.time_s) == 41 and log.exit_reason == "completed"
        assert (folder / name / "tracking.png").exists()


@pytest.mark.usefixtures("undrawn")
def test_the_saved_scenario_of_a_variant_repeats_its_flight(flown, tmp_path):
    _, folder, summaries = flown
    scenario, out = folder / "clik" / "scenario.yaml", tmp_path / "again"
    assert main(["run", str(scenario), "--quiet", "--out", str(out)]) == 0
    again = json.loads((out / "summary.json").read_text())
    assert repeatable(again) == repeatable(summaries["clik"])


def test_summaries_contain_the_workspace_use_of_the_arm(flown, vehicle):
    scenario, folder, summaries = flown
    for name, summary in summaries.items():
        log = FlightLog.read(folder / name / "log.npz", summary, vehicle)
        d_o = np.linalg.norm(log.p_EB_m - log.p_EB_m[0], axis=1)
        assert summary["arm"]["farthest_d_o_m"] == pytest.approx(d_o.max(), abs=1e-9)
        assert summary["arm"]["outside_s"] == 0
        assert 0.1 < summary["arm"]["least_room_rad"] < 1.6


def test_a_variant_that_raises_or_dies_has_a_summary_but_no_folder(monkeypatch, tmp_path, paper):
    monkeypatch.setattr(module, "run_parallel", in_this_process)
    monkeypatch.setattr(module, "_fly", fail_or_lose)
    variants = dict.fromkeys(("integral", "modified", "clik"), paper)
    seen = []
    summaries = fly_variants(variants, tmp_path, 2, seen.append)
    assert list(summaries) == list(variants) and seen == ["clik", "modified", "integral"]
    assert summaries["integral"] == {"exit_reason": "lost", "exit_cause": "tilt"}
    assert summaries["clik"] == {
        "exit_reason": "failed",
        "exit_cause": "RuntimeError: first line",
    }
    assert summaries["modified"] == {"exit_reason": "failed", "exit_cause": "MemoryError"}
    assert [path.name for path in tmp_path.iterdir()] == ["integral"]


def fail_or_lose(flight):
    _, folder = flight
    folder.mkdir()
    if folder.name == "clik":
        raise RuntimeError("first line\nsecond line")
    if folder.name == "modified":
        raise MemoryError
    return {"exit_reason": "lost", "exit_cause": "tilt"}

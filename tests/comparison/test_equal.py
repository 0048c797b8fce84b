"""Variants that equal another are flown once."""

from dataclasses import replace

import pytest

import aerodrake
from aerodrake.comparison.compare import make_variants
from aerodrake.comparison.equal import EQUAL_TO, equal_variants, share_margins, share_results
from aerodrake.comparison.margins import Margins
from aerodrake.comparison.table import comparison_rows
from aerodrake.scenario import Scenario, Weights
from aerodrake.scenario.load import load_scenario

ERROR = dict.fromkeys(("lap_mean_m", "settled_mean_m", "mean_m", "max_m", "approach_s"), 1e-3)
SUMMARY = {
    "exit_reason": "completed",
    "exit_cause": "",
    "error": ERROR,
    "residual": {"prediction_rmse_m_s": {"with_network": None}},
    "arm": {"farthest_d_o_m": 0.1, "outside_s": 0.0, "least_room_rad": 0.2},
}


def test_equal_scenarios_are_found_by_content():
    one, other = Scenario(name="one"), Scenario(name="one", seed=3)
    variants = {"a": one, "b": other, "c": replace(one), "d": replace(other), "e": replace(one)}
    assert equal_variants(variants) == {"c": "a", "d": "b", "e": "a"}
    assert equal_variants({}) == {}


@pytest.mark.parametrize(("w_4", "is_equal"), [(Weights().w_4, True), ((1.0, 2.0, 3.0), False)])
def test_the_best_integral_variant_may_be_the_integral_one(w_4, is_equal):
    """It is with the default weights, which `hover` has."""
    hover = load_scenario("hover")
    chosen = make_variants(hover, ["integral", "integral_best"], replace(Weights(), w_4=w_4))
    assert (equal_variants(chosen) == {"integral_best": "integral"}) == is_equal


def test_results_are_shared_and_shown_as_equal(tmp_path):
    """In the order of the variants, with a folder of its own."""
    (tmp_path / "integral").mkdir()
    (tmp_path / "integral" / "summary.json").write_text("{}")
    equal, names = {"integral_best": "integral"}, ["integral", "integral_best", "modified"]
    summaries = share_results(
        dict.fromkeys(("modified", "integral"), SUMMARY), equal, names, tmp_path
    )
    assert list(summaries) == names
    assert summaries["integral_best"] == SUMMARY | {EQUAL_TO: "integral"}
    assert (tmp_path / "integral_best" / "summary.json").read_text() == "{}"
    endings = [row[-1] for row in comparison_rows(summaries)]
    assert endings == ["completed", "completed, equal to integral", "completed"]


def test_failed_variants_have_nothing_to_share(tmp_path):
    failed = {"exit_reason": "failed", "exit_cause": "why"}
    summaries = share_results({"a": failed}, {"b": "a"}, ["a", "b"], tmp_path)
    assert comparison_rows(summaries)[1][-1] == "failed: why, equal to a"
    assert [*tmp_path.iterdir()] == []


def test_margins_are_shared():
    margins = share_margins(Margins("mean_m", {"a": {}, "c": {}}), {"b": "a"}, ["a", "b", "c"])
    assert list(margins.searches) == ["a", "b", "c"]
    assert margins.searches["b"] is margins.searches["a"]


def test_equal_variants_are_flown_once(monkeypatch, tmp_path):
    flown = []

    def fly(variants, folder, jobs, progress):
        flown.extend(variants)
        return dict.fromkeys(variants, {"exit_reason": "failed", "exit_cause": ""})

    monkeypatch.setattr("aerodrake.api.compare.fly_variants", fly)
    names = ["integral", "integral_best", "clik"]
    comparison = aerodrake.compare("hover", variants=names, quiet=True)
    assert flown == ["integral", "clik"] and list(comparison.summaries) == names
    assert comparison.summaries["integral_best"][EQUAL_TO] == "integral"

"""`aerodrake.compare` and its result."""

import json

import pytest

import aerodrake
from aerodrake.comparison import compare as module
from tests.in_this_process import in_this_process

SHORT = {"duration": 0.1, "settle_s": 0.0}


@pytest.fixture(scope="module")
def result():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "run_parallel", in_this_process)
        patch.setattr("aerodrake.reports.flight_folder.plot_tracking", lambda *a: a[-1].touch())
        return aerodrake.compare("hover", SHORT, variants=["clik", "modified"], quiet=True)


def test_a_comparison_has_summaries_and_flights(result):
    assert list(result.summaries) == ["modified", "clik"] and not result.failed
    flight = result.flight("clik")
    assert flight.scenario.controller == "clik"
    assert flight.error == result.summaries["clik"]["error"]
    assert "modified" in str(result) and "<pre>" in result._repr_html_()
    with pytest.raises(aerodrake.BadInput, match="variant: no flight of 'clic'; did you mean"):
        result.flight("clic")


@pytest.mark.usefixtures("undrawn")
def test_a_saved_comparison_has_a_run_for_each_variant(result, tmp_path):
    folder = result.save(tmp_path / "comparison")
    written = json.loads((folder / "comparison.json").read_text())
    assert list(written["variants"]) == ["modified", "clik"]
    assert aerodrake.load_run(folder / "clik").error == result.summaries["clik"]["error"]
    page = result.report(folder).read_text()
    command = f"aerodrake compare {folder}/scenario.yaml --variant=modified --variant=clik"
    assert command in page and f"aerodrake run {folder}/clik/scenario.yaml" in page
    assert aerodrake.load_scenario(folder / "scenario.yaml").duration == 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"variants": ["clic"]}, "variants: no such variant 'clic'; did you mean 'clik'"),
        ({"jobs": 0}, r"jobs: expected a whole number in \[1, 1000\], got 0"),
        ({"jobs": 1.5}, "compare: jobs: expected int or None, got 1.5"),
        ({"variants": 3}, "compare: variants: expected str or Sequence, got 3"),
        ({"baseline": 3}, "compare: baseline: expected str or PathLike or None, got 3"),
        ({"baseline": "none.yaml"}, "none.yaml: expected a readable file"),
        ({"mpc.horizon": 0}, "hover: mpc.horizon: expected a whole number"),
    ],
)
def test_bad_input_names_the_argument(arguments, message):
    with pytest.raises(aerodrake.BadInput, match=message):
        aerodrake.compare("hover", quiet=True, **arguments)

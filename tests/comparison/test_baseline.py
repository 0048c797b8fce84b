import pytest

from aerodrake.comparison.baseline import load_baseline
from aerodrake.scenario import Weights
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.support.errors import BadInput
from tests.modules import PACKAGE

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

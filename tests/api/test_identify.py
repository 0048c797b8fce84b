"""`aerodrake.identify` and its result."""

import pytest

import aerodrake
from tests.ideal_base import K_B, replace_flights


@pytest.fixture
def _ideal(monkeypatch):
    replace_flights(monkeypatch)


@pytest.mark.usefixtures("_ideal")
def test_the_result_has_k_b_and_the_scenario_with_it(tmp_path):
    result = aerodrake.identify("hover", seed=3, quiet=True)
    assert result.k_b == K_B == result.scenario.model.k_b
    assert "K_B" in str(result) and "<pre>" in result._repr_html_()
    folder = result.save(tmp_path / "identification")
    assert aerodrake.load_scenario(folder / "scenario.yaml").model.k_b == K_B
    assert result.report(folder).name == "identification.png"


def test_bad_input_names_the_argument():
    with pytest.raises(aerodrake.BadInput, match="jobs: expected a whole number"):
        aerodrake.identify("hover", jobs=0)

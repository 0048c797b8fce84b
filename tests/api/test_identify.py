"""`aerodrake.identify` and its result."""

import numpy as np
import pytest

import aerodrake
from aerodrake.identification import identify as module
from aerodrake.identification.identify import Manoeuvre, Record
from tests.in_this_process import in_this_process

K_B = (1.5, 2.0, 2.5)


@pytest.fixture
def _ideal(monkeypatch):
    """Replaces the flights by samples of a first-order base with `K_B`."""

    def fly(manoeuvre: Manoeuvre) -> Record:
        t = 0.02 * np.arange(1000)
        error = 0.1 * np.cos(t)
        return Record(t, error, 0 * t, K_B[manoeuvre.axis] * error)

    monkeypatch.setattr(module, "fly", fly)
    monkeypatch.setattr(module, "run_parallel", in_this_process)


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

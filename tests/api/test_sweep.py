"""`aerodrake.sweep` and its result."""

from concurrent.futures import ThreadPoolExecutor

import pytest

import aerodrake
from aerodrake.sweeps import loop
from aerodrake.sweeps.plan import Plan
from tests.in_this_process import call_in_this_process

SHORT = {"duration": 0.04, "settle_s": 0.0}
VARY = {"payload.mass_kg": "uniform(0, 0.5)"}


@pytest.fixture(autouse=True)
def _here(monkeypatch):
    """Flies trials in this process instead of child processes."""
    monkeypatch.setattr(loop, "call_in_child", call_in_this_process)


@pytest.fixture(scope="module")
def result():
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as executor:
        patch.setattr(loop, "call_in_child", call_in_this_process)
        return aerodrake.sweep(
            "hover", SHORT, vary=VARY, trials=2, executor=executor, quiet=True, seed=4
        )


def test_a_sweep_has_a_summary_and_a_row_for_each_trial(result):
    assert result.summary["endings"] == {"completed": 2} and result.summary["seed"] == 4
    assert [row["trial"] for row in result.rows] == [0, 1]
    assert all(0 <= row["parameters"]["payload.mass_kg"] <= 0.5 for row in result.rows)
    assert "hover, seed 4: 2 trials" in str(result) and "<img" in result._repr_html_()


def test_a_sweep_in_a_folder_can_get_more_trials(result, tmp_path):
    out = tmp_path / "sweep"
    options = {"vary": VARY, "out": out, "jobs": 1, "quiet": True, "seed": 4}
    first = aerodrake.sweep("hover", SHORT, trials=1, **options)
    assert {path.name for path in out.iterdir()} == {*Plan.files.all}
    more = aerodrake.sweep("hover", SHORT, trials=2, resume=True, **options)
    assert first.summary["trials"] == 1 and more.rows == result.rows


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"vary": {}}, "trials: expected a number of trials"),
        ({"vary": ["duration=uniform(1, 2)"]}, "sweep: vary: expected Mapping, got"),
        ({"vary": {3: "uniform(0, 1)"}, "trials": 1}, "vary: expected dotted keys, got 3"),
        ({"vary": VARY, "trials": True}, "sweep: trials: expected int or None, got True"),
        ({"vary": VARY, "trials": 1, "out": 3}, "sweep: out: expected str or PathLike or None"),
        ({"vary": VARY, "trials": 1, "executor": 3}, "sweep: executor: expected Executor or None"),
        ({"vary": VARY, "trials": 1, "scheduler": "nowhere"}, "scheduler: expected the address"),
        ({"vary": VARY, "trials": 0}, "trials: expected a whole number"),
        ({"vary": VARY, "trials": 1.5}, "trials: expected int or None, got 1.5"),
        ({"vary": {"mass": "uniform(0, 1)"}, "trials": 1}, "vary: mass: unknown key"),
        ({"vary": {"duration": "gamma(1)"}, "trials": 1}, "no such distribution 'gamma'"),
        ({"vary": {"duration": 3}, "trials": 1}, "vary: duration: expected "),
        ({"vary": VARY, "trials": 1, "resume": True}, "resume: expected the folder of a sweep"),
        ({"vary": VARY, "trials": 1, "jobs": -1}, "jobs: expected a whole number"),
    ],
)
def test_bad_input_names_the_argument(arguments, message):
    with pytest.raises(aerodrake.BadInput, match=message):
        aerodrake.sweep("hover", quiet=True, **arguments)

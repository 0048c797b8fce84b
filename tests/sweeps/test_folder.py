"""Folder of a sweep: created, resumed, replaced, and locked."""

import json
from pathlib import Path

import pytest

from aerodrake.scenario.load import load_with_options
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.errors import BadInput
from aerodrake.sweeps.folder import read_rows, sweep_folder
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS, TIMINGS
from tests.plans import by_key

GUSTS = "wind.gust_m_s[0]=uniform(0, 1)"


def make(*vary: str, trials: int = 5, changes=(), scenario="hover") -> Plan:
    overrides = [("--set", change) for change in changes]
    return Plan.make(load_with_options(scenario, overrides), by_key(vary or [GUSTS]), trials)


def row(index: int) -> dict:
    return {"trial": index, "exit_reason": "completed"}


def begin(target: Path, plan: Plan, *indices: int, resumes: bool = False) -> None:
    with sweep_folder(target, plan, resumes) as folder:
        for index in indices:
            folder.append(row(index), {"trial": index, "wall_s": 1.0})


def refusal(target: Path, plan: Plan, resumes: bool) -> str:
    with pytest.raises(BadInput) as refused, sweep_folder(target, plan, resumes):
        pytest.fail("expected it to be refused")
    assert len(str(refused.value).splitlines()) == 1
    return str(refused.value)


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_the_folder_contains_the_plan_and_a_row_for_each_trial(tmp_path):
    target, plan = tmp_path / "deep" / "sweep", make()
    with sweep_folder(target, plan, resumes=False) as folder:
        assert {path.name for path in target.iterdir()} == {*Plan.files.all[:4]}
        assert as_mapping(folder.plan.scenario) == as_mapping(plan.scenario)
        folder.append(row(3), None)
        assert [*read_rows(target)] == [row(3)] and folder.recorded == {3}
    stored = json.loads((target / "sweep.json").read_text())
    assert stored["vary"] == {"wind.gust_m_s[0]": "uniform(0, 1)"}
    assert (stored["trials"], stored["seed"], stored["scenario"]) == (5, 0, "hover")
    assert [path.name for path in target.parent.iterdir()] == ["sweep"]


def test_files_of_the_scenario_are_copied_and_compared(tmp_path):
    path = tmp_path / "path.csv"
    path.write_text("t,x,y,z\n0,0,0.2,1.2\n1,0.1,0.2,1.2\n")
    plan = make(scenario="waypoints", changes=[f"reference.file={path}"])
    begin(tmp_path / "sweep", plan, 0)
    before = path.read_text()
    path.write_text(before.replace("0.1", "0.3"))
    expected = "resume: inputs/path.csv: the sweep in "
    assert refusal(tmp_path / "sweep", plan, True).startswith(expected)
    path.write_text(before)
    with sweep_folder(tmp_path / "sweep", plan, True) as folder:
        own = Path(folder.plan.scenario.reference.file)
        assert own.is_relative_to(tmp_path / "sweep") and own.read_text() == before


@pytest.mark.parametrize("torn", [b'{"trial": 2', b'{"trial": 2}', b"\0\0\0", b""])
def test_an_incomplete_row_is_dropped_and_the_others_stay(torn, tmp_path):
    begin(tmp_path / "sweep", make(), 4, 1)
    with open(tmp_path / "sweep" / ROWS, "ab") as rows:
        rows.write(torn)
    begin(tmp_path / "sweep", make(), 2, resumes=True)
    assert [r["trial"] for r in read_rows(tmp_path / "sweep")] == [4, 1, 2]


@pytest.mark.parametrize(
    "line", ["{", "[]", "3", '{"trial": 9}', '{"trial": 4}', '{"trial": "0"}', "{}"]
)
def test_an_invalid_row_is_reported(line, tmp_path):
    begin(tmp_path / "sweep", make(), 4, 1)
    with open(tmp_path / "sweep" / ROWS, "a") as rows:
        rows.write(line + "\n")
    assert "trials.jsonl: line 3: expected " in refusal(tmp_path / "sweep", make(), True)


@pytest.mark.parametrize("name", [ROWS, TIMINGS])
def test_a_missing_file_is_named(name, tmp_path):
    begin(tmp_path / "sweep", make(), 4, 1)
    (tmp_path / "sweep" / name).unlink()
    assert f"{name}: expected a file of the sweep: No such" in refusal(
        tmp_path / "sweep", make(), True
    )


def test_a_sweep_is_resumed_with_more_trials_but_not_with_fewer(tmp_path):
    target = tmp_path / "sweep"
    begin(target, make(), 0, 1, 2, 3, 4)
    (target / Plan.files.summary).touch()
    with sweep_folder(target, make(), True):
        assert (target / Plan.files.summary).exists()
    with sweep_folder(target, make(trials=7), True) as folder:
        assert not (target / Plan.files.summary).exists() and folder.recorded == {0, 1, 2, 3, 4}
    assert json.loads((target / "sweep.json").read_text())["trials"] == 7
    assert "resume: trials: the sweep in" in refusal(target, make(), True)


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (make("payload.mass_kg=uniform(0, 1)"), "vary.wind.gust_m_s[0]: the sweep"),
        (make("wind.gust_m_s[0]=uniform(0, 2)"), "has uniform(0, 1), not uniform(0, 2)"),
        (make(GUSTS, "payload.mass_kg=uniform(0, 1)"), "vary.payload.mass_kg: the sweep"),
        (make(changes=["seed=3"]), "seed: the sweep"),
        (make(changes=["mpc.horizon=20"]), "mpc.horizon: the sweep"),
        (make(scenario="clover"), "the sweep"),
    ],
)
def test_another_plan_is_refused_with_the_key_that_differs(other, expected, tmp_path):
    begin(tmp_path / "sweep", make(), 1)
    before = files(tmp_path)
    message = refusal(tmp_path / "sweep", other, True)
    assert message.startswith("resume: ") and expected in message
    assert files(tmp_path) == before


def test_equal_distributions_may_differ_in_notation(tmp_path):
    words = "residual.mode=choice(off,online)"
    begin(tmp_path / "sweep", make(GUSTS, words), 1)
    again = make("wind.gust_m_s[0]=uniform( 0.0, 1e0 )", "residual.mode=choice('off', online)")
    with sweep_folder(tmp_path / "sweep", again, True) as folder:
        assert folder.recorded == {1}


def test_a_grid_in_another_order_is_another_plan(tmp_path):
    """The first key changes fastest; random values are the same in any order."""
    across, along = (f"wind.velocity_m_s[{axis}]=linspace(0, 1, 2)" for axis in (0, 1))
    begin(tmp_path / "sweep", make(across, along, GUSTS), 1)
    with sweep_folder(tmp_path / "sweep", make(GUSTS, across, along), True) as folder:
        assert folder.recorded == {1}
    message = refusal(tmp_path / "sweep", make(along, across, GUSTS), True)
    assert message.startswith("resume: vary: the sweep in ") and message.endswith(
        "[1]', 'wind.velocity_m_s[0]']"
    )


def test_a_plan_with_invalid_distributions_is_refused(tmp_path):
    begin(tmp_path / "sweep", make(), 1)
    plan = tmp_path / "sweep" / "sweep.json"
    plan.write_text(plan.read_text().replace("uniform(", "uniform"))
    assert "sweep.json: expected the plan of a sweep" in refusal(tmp_path / "sweep", make(), True)


def test_another_version_is_refused(tmp_path):
    begin(tmp_path / "sweep", make(), 1)
    plan = tmp_path / "sweep" / "sweep.json"
    plan.write_text(plan.read_text().replace('"version": "', '"version": "0.'))
    assert "resume: version: the sweep" in refusal(tmp_path / "sweep", make(), True)


def test_an_unfinished_sweep_is_not_replaced_but_a_finished_one_is(tmp_path):
    target = tmp_path / "sweep"
    begin(target, make(), 1)
    before = files(target)
    assert "`resume` continues it" in refusal(target, make(), False)
    assert files(target) == before
    for name in (Plan.files.summary, "sweep.png"):
        (target / name).touch()
    begin(target, make(trials=2), 0)
    assert [r["trial"] for r in read_rows(target)] == [0] and not (
        target / Plan.files.summary
    ).exists()


@pytest.mark.parametrize("resumes", [False, True])
def test_a_folder_with_other_files_is_left_alone(resumes, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / ROWS).write_text("precious")
    (tmp_path / "file").write_text("precious")
    expected = "contains no sweep" if resumes else "holds files that are not of an earlier run"
    assert expected in refusal(tmp_path / "mine", make(), resumes)
    refusal(tmp_path / "file", make(), resumes)
    refusal(tmp_path / "file" / "below", make(), resumes)
    assert files(tmp_path) == {f"mine/{ROWS}": b"precious", "file": b"precious"}


def test_a_missing_folder_cannot_be_resumed(tmp_path):
    assert "expected the folder of a sweep" in refusal(tmp_path / "none", make(), True)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"trials": 1}', '{"trials": "1", "vary": {}}'])
def test_an_invalid_plan_is_reported(text, tmp_path):
    begin(tmp_path / "sweep", make(), 1)
    (tmp_path / "sweep" / "sweep.json").write_text(text)
    assert "sweep.json: expected the plan of a sweep" in refusal(tmp_path / "sweep", make(), True)


@pytest.mark.parametrize("resumes", [False, True])
def test_a_folder_is_locked_by_one_sweep(resumes, tmp_path):
    target = tmp_path / "sweep"
    with sweep_folder(target, make(), False) as folder:
        assert "another sweep writes to" in refusal(target, make(), resumes)
        folder.append(row(0), None)
    begin(target, make(), 1, resumes=True)
    assert len([*read_rows(target)]) == 2


def test_a_finished_sweep_is_not_replaced_while_trials_are_added(tmp_path):
    target = tmp_path / "sweep"
    begin(target, make(), 0)
    for name in (Plan.files.summary, "sweep.png"):
        (target / name).touch()
    with sweep_folder(target, make(), True):
        assert "another sweep writes to" in refusal(target, make(), False)

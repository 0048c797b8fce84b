"""Results, failures and deaths of parallel processes, and stopping them early."""

import multiprocessing
import os
import time
from pathlib import Path

import pytest

from aerodrake.support.errors import ProcessDied
from aerodrake.support.processes import run_parallel


def square(number: int) -> tuple[int, int]:
    return number**2, os.getpid()


def refuse_odd(number: int) -> int:
    if number % 2:
        raise ValueError(f"{number} is odd")
    return number


def die_of_one(number: int) -> int:
    if number == 1:
        os._exit(3)
    return number


def meet(item: tuple[Path, str]) -> str:
    """Returns only if two processes run at the same time."""
    folder, name = item
    (folder / name).touch()
    while len(list(folder.iterdir())) < 2:
        time.sleep(0.01)
    return name


def linger(item: tuple[Path, str]) -> str:
    """Returns for "quick" as soon as the process of "slow", which never ends, has begun."""
    folder, name = item
    if name == "slow":
        (folder / "begun").write_text(str(os.getpid()))
        time.sleep(600)
        (folder / "ended").touch()
    while not (folder / "begun").exists():
        time.sleep(0.01)
    return name


def test_each_item_has_its_own_process():
    results = dict(run_parallel(square, [3, 1, 2], jobs=2))
    assert {index: value for index, (value, _) in results.items()} == {0: 9, 1: 1, 2: 4}
    pids = {pid for _, pid in results.values()}
    assert len(pids) == 3 and os.getpid() not in pids


def test_items_may_be_appended_during_the_iteration():
    """Each number below 8 appends that number plus 3."""
    items = [2, 5]
    results = []
    for index, result in run_parallel(refuse_odd, items, jobs=2):
        results.append((items[index], str(result)))
        if items[index] < 8:
            items.append(items[index] + 3)
    assert sorted(results) == [
        (2, "2"), (5, "5 is odd"), (5, "5 is odd"), (8, "8"), (8, "8")
    ]  # fmt: skip


def test_no_items():
    assert list(run_parallel(square, [], jobs=2)) == []


def test_an_exception_fails_only_its_own_item():
    results = dict(run_parallel(refuse_odd, [2, 3, 4], jobs=2))
    assert (results[0], results[2]) == (2, 4)
    assert isinstance(results[1], ValueError) and str(results[1]) == "3 is odd"


def test_a_dead_process_fails_only_its_own_item():
    results = dict(run_parallel(die_of_one, [0, 1, 2], jobs=1))
    assert (results[0], results[2]) == (0, 2)
    assert isinstance(results[1], ProcessDied) and str(results[1]).endswith("of exit code 3")


def test_jobs_run_at_the_same_time(tmp_path):
    items = [(tmp_path, "a"), (tmp_path, "b")]
    assert sorted(result for _, result in run_parallel(meet, items, jobs=2)) == ["a", "b"]


@pytest.mark.parametrize("closes", [True, False])
def test_stopping_the_iteration_ends_all_processes(closes, tmp_path):
    """The iteration is closed, or receives an exception such as that of Ctrl-C."""
    results = run_parallel(linger, [(tmp_path, "quick"), (tmp_path, "slow")], jobs=2)
    assert next(results) == (0, "quick")
    if closes:
        results.close()
    else:
        with pytest.raises(KeyboardInterrupt):
            results.throw(KeyboardInterrupt)
    assert multiprocessing.active_children() == []
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "begun").read_text()), 0)
    assert not (tmp_path / "ended").exists()

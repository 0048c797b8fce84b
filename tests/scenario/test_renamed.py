"""Keys of earlier versions are refused with their new name, wherever they are given."""

import typing

import pytest

from aerodrake.scenario import AnyFault, Orientation, Reference, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.scenario.renamed import REMOVED, RENAMED, successor
from aerodrake.scenario.schema import as_mapping
from tests.refusals import refuses


def keys(data: dict, prefix: str = "") -> set[str]:
    """Returns the dotted keys of a mapping and of the mappings in it."""
    inner = {f"{prefix}{name}": value for name, value in data.items()}
    nested = [keys(value, f"{key}.") for key, value in inner.items() if isinstance(value, dict)]
    return set(inner).union(*nested)


def current_keys() -> set[str]:
    """Returns every dotted key of every kind of section."""
    names = keys(as_mapping(Scenario()))
    for section, union in (
        ("reference", Reference), ("orientation", Orientation), ("faults", AnyFault)
    ):  # fmt: skip
        for kind in typing.get_args(union):
            names |= keys(as_mapping(kind()), f"{section}.")
    return names


@pytest.fixture
def earlier(monkeypatch):
    """Adds a renamed key, a renamed section, a renamed key of a fault and a removed section."""
    monkeypatch.setitem(RENAMED, "mpc.stages", "mpc.horizon")
    monkeypatch.setitem(RENAMED, "eso", "flight")
    monkeypatch.setitem(RENAMED, "faults.begin_s", "faults.start_s")
    monkeypatch.setitem(REMOVED, "trim", "every flight starts in trim")


def test_the_tables_agree_with_the_keys_of_a_scenario():
    assert not current_keys() & (RENAMED.keys() | REMOVED.keys())
    assert set(RENAMED.values()) <= current_keys()
    assert not RENAMED.keys() & REMOVED.keys()


def test_keys_that_never_existed_have_no_successor(earlier):
    assert successor("mpc.stage") == successor("mpc") == successor("") == ""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mpc: {stages: 9}", "mpc.stages: renamed to mpc.horizon"),
        ("eso: {bandwidth: 9}", "eso: renamed to flight"),
        ("trim: {}", "trim: removed; every flight starts in trim"),
        (
            "faults: [{kind: push}, {kind: push, begin_s: 1}]",
            "faults[1].begin_s: renamed to faults.start_s",
        ),
    ],
)
def test_an_earlier_file_is_refused_with_the_new_key(text, expected, write, earlier):
    path = write(text)
    assert refuses(path) == f"{path}: {expected}"


@pytest.mark.parametrize(
    ("assignment", "expected"),
    [
        ("mpc.stages=9", "mpc.stages: renamed to mpc.horizon"),
        ("eso.bandwidth=9", "eso: renamed to flight"),
        ("trim.thrust=9", "trim: removed; every flight starts in trim"),
        ("trim=9", "trim: removed; every flight starts in trim"),
    ],
)
def test_an_earlier_override_is_refused_with_the_new_key(assignment, expected, earlier):
    assert refuses("hover", ("--set", assignment)) == f"--set: {expected}"


def test_every_earlier_key_is_refused(write):
    for key, advice in [
        *((old, f"renamed to {new}") for old, new in RENAMED.items()),
        *((old, f"removed; {reason}") for old, reason in REMOVED.items()),
    ]:
        assert advice in refuses("hover", ("--set", f"{key}=1"))
    assert load_scenario("hover").name == "hover"

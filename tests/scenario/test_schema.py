"""`build` and `as_mapping` on example sections."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from aerodrake.scenario.schema import (
    Kind,
    Section,
    as_mapping,
    build,
    choice,
    file,
    map_files,
    provenance,
    quantity,
)
from aerodrake.scenario.values import MAX_LIST
from aerodrake.support.errors import ScenarioError


@dataclass(frozen=True)
class Ring(Kind, kind="ring"):
    radius_m: float = quantity(1.0, "m", 0.0, 5.0)


@dataclass(frozen=True)
class Line(Kind, kind="line"):
    table: str = file()


@dataclass(frozen=True)
class Disc(Section):
    radius_m: float = quantity(1.0, "m", 0.0, 5.0)


@dataclass(frozen=True)
class Root(Section):
    title: str = ""
    speed: float = quantity(1.5, "m/s", -2.0, 2.0)
    mass: float = quantity(1.0, "kg")
    count: int = quantity(3, "ticks", 1, 10)
    gains: tuple[float, ...] = quantity((1.0, 2.0), "1/s", 0.0, 9.0, length=2)
    angles: tuple[float, ...] = quantity((), "rad", -1.0, 1.0)
    mode: str = choice("off", "slow", "on")
    quiet: bool = False
    path: Ring | Line = Ring()
    inner: Disc = Disc()
    data: str = file("package://aerodrake/robots/x")
    source: str = provenance()


def fails(data: object, expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        build(Root, data, "f.yaml")
    message = str(caught.value)
    assert message.startswith("f.yaml: ") and expected in message, message
    assert len(message) < 500


def test_missing_keys_have_their_defaults():
    assert build(Root, {}, "f.yaml") == Root()


def test_every_type_is_read():
    built = build(
        Root,
        {
            "title": "A title",
            "speed": -2,
            "mass": -1e9,
            "count": 10,
            "gains": [0, 9.0],
            "angles": [0.1, 0.2, 0.3],
            "mode": "slow",
            "quiet": True,
            "path": {"kind": "line", "table": "a.csv"},
            "inner": {"radius_m": 5},
            "data": "b.npz",
        },
        "f.yaml",
    )
    assert built == Root(
        title="A title",
        speed=-2.0,
        mass=-1e9,
        count=10,
        gains=(0.0, 9.0),
        angles=(0.1, 0.2, 0.3),
        mode="slow",
        quiet=True,
        path=Line(table="a.csv"),
        inner=Disc(radius_m=5.0),
        data="b.npz",
    )
    assert type(built.speed) is float and type(built.gains[0]) is float
    assert type(built.count) is int


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        # Names.
        ({"sped": 1.0}, "sped: unknown key; did you mean 'speed'? (valid: angles, count,"),
        ({"inner": {"radius": 1.0}}, "inner.radius: unknown key; did you mean 'radius_m'?"),
        ({"path": {"kind": "ring", "table": "a"}}, "path.table: unknown key"),
        ({"source": "x"}, "source: unknown key"),
        ({"inner": {"kind": "ring"}}, "inner.kind: unknown key"),
        ({3: 1.0}, "3: unknown key"),
        ({None: 1.0}, "None: unknown key"),
        # Kinds.
        ({"path": {"radius_m": 1.0}}, "path: expected a mapping with a kind; valid: line, ring"),
        ({"path": "ring"}, "path: expected a mapping with a kind; valid: line, ring"),
        ({"path": {"kind": "rung"}}, "path.kind: unknown kind 'rung'; did you mean 'ring'?"),
        ({"path": {"kind": ["ring"]}}, "path.kind: unknown kind"),
        # Mappings.
        (None, "expected a mapping"),
        ([], "expected a mapping"),
        ({"inner": 3}, "inner: expected a mapping of keys to values, got 3"),
        ({"inner": None}, "inner: expected a mapping of keys to values, got None"),
        # Numbers.
        ({"speed": "10 m/s"}, "speed: expected a number in [-2, 2] m/s, got '10 m/s'"),
        ({"speed": ""}, "speed: expected a number in [-2, 2] m/s, got ''"),
        ({"speed": math.nan}, "speed: expected a number in [-2, 2] m/s, got nan"),
        ({"speed": "1"}, "speed: expected a number in [-2, 2] m/s, got '1'"),
        ({"speed": "nan"}, "speed: expected a number in [-2, 2] m/s, got 'nan'"),
        ({"mass": math.inf}, "mass: expected a number in [-inf, inf] kg, got inf"),
        ({"speed": 10**400}, "speed: expected"),
        ({"speed": True}, "speed: expected a number in [-2, 2] m/s, got True"),
        ({"speed": None}, "speed: expected a number in [-2, 2] m/s, got None"),
        ({"speed": [1.0]}, "speed: expected a number in [-2, 2] m/s, got [1.0]"),
        ({"speed": {"x": 1.0}}, "speed: expected a number"),
        ({"speed": math.nextafter(2, 3)}, "speed: expected a number in [-2, 2] m/s"),
        ({"speed": -2.1}, "speed: expected a number in [-2, 2] m/s, got -2.1"),
        ({"count": 2.5}, "count: expected a whole number in [1, 10] ticks, got 2.5"),
        ({"count": 0}, "count: expected a whole number in [1, 10] ticks, got 0"),
        ({"count": 11}, "count: expected a whole number in [1, 10] ticks, got 11"),
        ({"count": True}, "count: expected a whole number in [1, 10] ticks, got True"),
        # Lists.
        ({"gains": 1.0}, "gains: expected a list of 2 numbers in 1/s, got 1.0"),
        ({"gains": "1 2"}, "gains: expected a list of 2 numbers in 1/s, got '1 2'"),
        ({"gains": [1.0]}, "gains: expected a list of 2 numbers in 1/s, got 1"),
        ({"gains": [1.0] * 3}, "gains: expected a list of 2 numbers in 1/s, got 3"),
        ({"gains": {"x": 1, "y": 2}}, "gains: expected a list of 2 numbers"),
        ({"gains": [1.0, 9.1]}, "gains[1]: expected a number in [0, 9] 1/s, got 9.1"),
        ({"gains": [1.0, [2.0]]}, "gains[1]: expected a number in [0, 9] 1/s, got [2.0]"),
        ({"gains": [1.0, False]}, "gains[1]: expected a number in [0, 9] 1/s, got False"),
        ({"angles": [0.0] * (MAX_LIST + 1)}, "angles: expected a list of numbers in rad"),
        # Strings.
        ({"mode": "slw"}, "mode: unknown value 'slw'; did you mean 'slow'? (valid: off, on, slow)"),
        ({"mode": 3}, "mode: expected a string, got 3"),
        ({"mode": False}, "mode: expected a string, got False"),
        ({"title": None}, "title: expected a string, got None"),
        ({"title": ["a"]}, "title: expected a string, got ['a']"),
        ({"quiet": 1}, "quiet: expected true or false, got 1"),
        ({"quiet": "yes"}, "quiet: expected true or false, got 'yes'"),
    ],
)
def test_an_invalid_value_is_named(data, expected):
    fails(data, expected)


@pytest.mark.parametrize("key", ["speed", "mode", "title", "inner", "path", "gains", "nonsense"])
def test_messages_are_short_for_any_input(key):
    nested: list = ["lol"] * 9
    for _ in range(30):
        nested = [nested] * 9
    for hostile in (nested, "k" * 100_000, {"kind": "k" * 100_000}, {"k" * 100_000: 1}):
        try:
            build(Root, {key: hostile}, "f.yaml")
        except ScenarioError as error:
            assert len(str(error)) < 2000
        else:
            assert key == "title" and isinstance(hostile, str)


def test_a_whole_number_may_be_a_float():
    assert build(Root, {"count": 4.0}, "f.yaml").count == 4


def test_a_boolean_is_not_a_string():
    fails({"title": False}, "title: expected a string, got False")


def test_errors_start_with_the_given_key():
    with pytest.raises(ScenarioError, match=r"^--set: outer\.speed: expected a number"):
        build(Root, {"speed": 3}, "--set", "outer")


@pytest.mark.parametrize(
    "config", [Root(), Root(path=Line(table="a.csv"), angles=(0.5,), mode="on", source="f.yaml")]
)
def test_as_mapping_is_the_inverse_of_build(config):
    mapping = as_mapping(config)
    assert mapping["path"]["kind"] == config.path.kind
    assert "source" not in mapping
    assert mapping["angles"] == list(config.angles)
    assert replace(build(Root, mapping, "g.yaml"), source=config.source) == config


def test_map_files_skips_packaged_and_empty_files():
    config = Root(path=Line(table="a.csv"), data="b.npz", title="c.csv")
    moved = map_files(config, lambda path: Path("/there") / path)
    assert moved == Root(path=Line(table="/there/a.csv"), data="/there/b.npz", title="c.csv")
    assert map_files(Root(path=Line()), lambda path: Path("/there")) == Root(path=Line())

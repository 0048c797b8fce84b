"""Any invalid value at any key is refused alike, whichever way the scenario is built.

The keys and their ranges are those that the sections declare.
"""

import dataclasses
import json
import math
import typing
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from aerodrake.scenario import AnyFault, Hover, Orientation, Reference, Scenario
from aerodrake.scenario.load import load_scenario, load_with_options, override
from aerodrake.scenario.schema import Kind, Section, as_mapping, union_fields
from aerodrake.support.errors import ScenarioError

BASE = Scenario(name="base", faults=[{"kind": "push"}, {"kind": "push"}])
NAMED = {"waypoints": {"file": "/path.csv"}, "along": {"file": "/axis.csv"}}


class Key(typing.NamedTuple):
    """A key of a scenario, and the scenario of defaults that has it."""

    dotted: str
    field: dataclasses.Field
    scenario: Scenario


def keys(scenario: Scenario, section: object, prefix: str = "") -> typing.Iterator[Key]:
    """Yields every key below a section that is not a section itself."""
    for field in dataclasses.fields(section):
        value, dotted = getattr(section, field.name), f"{prefix}{field.name}"
        if isinstance(value, Section):
            yield from keys(scenario, value, f"{dotted}.")
        elif not {"provenance"} & field.metadata.keys() and field.name != "faults":
            yield Key(dotted, field, scenario)


def make(kind: type[Kind]) -> Kind:
    """Returns a section of a union with what has no default."""
    return kind(**NAMED.get(kind.kind, {}))


def all_keys() -> typing.Iterator[Key]:
    """Yields the keys of all sections and of all kinds of references, orientations, faults."""
    yield from keys(BASE, BASE)
    for name, kinds in (("reference", Reference), ("orientation", Orientation)):
        for kind in map(make, typing.get_args(kinds)):
            scenario = dataclasses.replace(BASE, **{name: kind})
            yield from keys(scenario, kind, f"{name}.")
    for kind in typing.get_args(AnyFault):
        scenario = dataclasses.replace(BASE, faults=(BASE.faults[0], kind()))
        yield from keys(scenario, scenario.faults[1], "faults[1].")


KEYS = {f"{key.dotted} {i}": key for i, key in enumerate(all_keys())}
WRONG = st.sampled_from([None, {"x": 1}, [], [[1.0]], "x y", b"3", object, Hover(), 1j, {1}])
"""Values that are of the wrong type at any key; some have no form in YAML."""


def below_or_above(low: float, high: float) -> st.SearchStrategy:
    """Returns numbers out of a range, of several types."""
    outside = st.floats(max_value=low, exclude_max=True) | st.floats(high, exclude_min=True)
    far = st.sampled_from([int(low) - 1, int(high) + 1, np.float64(low - 1), np.int64(high + 1)])
    return outside | far | st.sampled_from([math.nan, math.inf, np.nan, True, "1", None, [0.0]])


def invalid(field: dataclasses.Field, default: object) -> st.SearchStrategy:
    """Returns values that the declaration of a field excludes, with the suffix of their key."""
    meta = field.metadata
    if isinstance(default, bool):
        return st.tuples(st.just(""), WRONG | st.sampled_from([0, 1, "true", np.int64(1)]))
    if isinstance(default, str):
        texts = st.sampled_from([3, True, math.nan, "a\0b", "\x1b[31m"])
        if "options" in meta:
            texts |= st.text("abc", max_size=6).filter(lambda text: text not in meta["options"])
        if "file" in meta:
            texts |= st.sampled_from(["package://other/x", "package://aerodrake/../x"])
        return st.tuples(st.just(""), texts | WRONG.filter(lambda value: value != "x y"))
    numbers = below_or_above(meta["low"], meta["high"])
    if isinstance(default, int):
        numbers |= st.just(meta["low"] + 0.5)
    if not isinstance(default, tuple):
        return st.tuples(st.just(""), numbers | WRONG)
    elements = st.integers(0, len(default) - 1).flatmap(
        lambda i: st.tuples(
            st.just(f"[{i}]"), numbers.map(lambda x: [*default[:i], x, *default[i + 1 :]])
        )
    )
    if not meta["length"]:
        return elements | st.tuples(st.just(""), WRONG.filter(lambda v: not isinstance(v, list)))
    lengths = st.integers(0, 5).filter(lambda n: n != meta["length"])
    short = lengths.map(lambda n: st.just(default[:1] * n)).flatmap(lambda value: value)
    return elements | st.tuples(st.just(""), short | short.map(np.array) | numbers | WRONG)


def replaced(section: Section, parents: list[str], leaf: str, value: object) -> Section:
    """Returns a section with a value at a key, by `dataclasses.replace` on each level."""
    if not parents:
        return dataclasses.replace(section, **{leaf: value})
    name, *below = parents
    if name.endswith("[1]"):  # Of the list of faults.
        name = name.removesuffix("[1]")
        first, second = getattr(section, name)
        inner: object = (first, replaced(second, below, leaf, value))
    else:
        inner = replaced(getattr(section, name), below, leaf, value)
    return dataclasses.replace(section, **{name: inner})


def value_at(scenario: Scenario, parents: list[str], leaf: str) -> object:
    """Returns the value at a key."""
    section: object = scenario
    for name in parents:
        section = scenario.faults[1] if name == "faults[1]" else getattr(section, name)
    return getattr(section, leaf)


def mapping(scenario: Scenario, parents: list[str], leaf: str, value: object) -> dict:
    """Returns a mapping of the kinds of a scenario, and of a value at a key."""
    data = node = {name: as_mapping(getattr(scenario, name)) for name in union_fields(Scenario)}
    for name in parents:
        node = node["faults"][1] if name == "faults[1]" else node.setdefault(name, {})
    node[leaf] = value
    return data


def yaml_form(value: object) -> str | None:
    """Returns the value in YAML, None if it has no form there."""
    if isinstance(value, float) and not math.isfinite(value):
        return {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}[str(value)]
    try:
        text = json.dumps(value.tolist() if hasattr(value, "tolist") else value)
    except TypeError:
        return None
    return None if "NaN" in text or "Infinity" in text else text


def refusal(build: typing.Callable[..., object], *arguments: object, **fields: object) -> tuple:
    """Returns key and message with which a scenario is refused."""
    with pytest.raises(ScenarioError) as caught:
        build(*arguments, **fields)
    assert str(caught.value).isprintable() and len(str(caught.value)) < 2000
    return caught.value.args[1:]


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("ways") / "flight.yaml"


@pytest.mark.parametrize("name", KEYS)
def test_an_invalid_value_is_refused_alike_in_every_way(name, path, long):
    key, field, scenario = KEYS[name]
    *parents, leaf = key.split(".")

    @settings(max_examples=100 if long else 2)
    @given(invalid(field, value_at(scenario, parents, leaf)))
    def check(wrong):
        suffix, value = wrong
        data = mapping(scenario, parents, leaf, value)
        refused = refusal(Scenario, **data)  # Direct construction, from mappings.
        assert refused[0] == key + suffix, refused
        assert refusal(override, scenario, {key: value}) == refused
        ours, theirs = refusal(replaced, scenario, parents, leaf, value), refused
        # A fault that is built by itself has no index.
        assert (ours[0].replace("[]", "[1]", 1), ours[1]) == theirs
        text = yaml_form(value)
        if text is not None:
            file = json.dumps(mapping(scenario, parents, leaf, "VALUE")).replace('"VALUE"', text)
            path.write_text(file)
            assert refusal(load_scenario, path)[0] == refused[0]
            path.write_text(json.dumps(mapping(scenario, [], "seed", 0)))
            option = ("--set", f"{key}={text}")
            assert refusal(load_with_options, str(path), [option])[0] == refused[0]

    check()

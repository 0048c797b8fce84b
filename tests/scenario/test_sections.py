"""Every key of a scenario is checked as declared."""

import dataclasses
import math
import typing

import pytest

from aerodrake.scenario import (
    AnyFault,
    AxisAlong,
    Hover,
    Orientation,
    Push,
    Reference,
    Scenario,
    Waypoints,
)
from aerodrake.scenario.schema import as_mapping, build
from aerodrake.support.errors import BadInput

NAMED = {Waypoints: {"file": "/path.csv"}, AxisAlong: {"file": "/axis.csv"}}
KINDS = [kind(**NAMED.get(kind, {})) for kind in typing.get_args(Reference)]
ORIENTATIONS = [kind(**NAMED.get(kind, {})) for kind in typing.get_args(Orientation)]


def nested(values: dict[str, object], reference: object = Hover()) -> dict:
    """Returns the mapping of a scenario with values at dotted keys and a kind of reference."""
    data: dict = {"reference": {"kind": reference.kind, **NAMED.get(type(reference), {})}}
    for key, value in values.items():
        *parents, leaf = key.split(".")
        node = data
        for parent in parents:
            node = node.setdefault(parent, {})
        node[leaf] = value
    return data


def leaves(config: object, prefix: str = ""):
    """Yields (dotted key, dataclass field, default) of every key that is not a section."""
    for field in dataclasses.fields(config):
        value, key = getattr(config, field.name), f"{prefix}{field.name}"
        if dataclasses.is_dataclass(value):
            yield from leaves(value, f"{key}.")
        elif "provenance" not in field.metadata:
            yield key, field, value


def sections(config: object, prefix: str = ""):
    """Yields (prefix of dotted keys, names of keys) of every section."""
    yield prefix, [f.name for f in dataclasses.fields(config) if "provenance" not in f.metadata]
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            yield from sections(value, f"{prefix}{field.name}.")


FAULTS = [fault() for fault in typing.get_args(AnyFault)]
LEAVES = [(Hover(), *leaf) for leaf in leaves(Scenario())]
LEAVES += [(kind, *leaf) for kind in KINDS for leaf in leaves(kind, "reference.")]
QUANTITIES = [leaf for leaf in LEAVES if "unit" in leaf[2].metadata]


def refuses(reference: object, key: str, value: object) -> str:
    """Returns the message about an invalid value, after checking that it names the key."""
    with pytest.raises(BadInput) as caught:
        build(Scenario, nested({key: value}, reference), "f.yaml")
    message = str(caught.value)
    assert message.startswith(f"f.yaml: {key}")
    return message


@pytest.mark.parametrize("reference", KINDS, ids=lambda kind: kind.kind)
def test_mapping_round_trip(reference):
    scenario = Scenario(reference=reference)
    assert build(Scenario, as_mapping(scenario), "f.yaml") == scenario
    assert build(Scenario, nested({}, reference), "f.yaml") == scenario


@pytest.mark.parametrize("orientation", ORIENTATIONS, ids=lambda kind: kind.kind)
def test_every_kind_of_orientation(orientation):
    scenario = Scenario(orientation=orientation)
    assert build(Scenario, as_mapping(scenario), "f.yaml") == scenario
    named = {"kind": orientation.kind, **NAMED.get(type(orientation), {})}
    assert build(Scenario, {"orientation": named}, "f.yaml") == scenario
    data = {"orientation": {"kind": orientation.kind, "axes": [0, 0, 1]}}
    with pytest.raises(BadInput, match="f.yaml: orientation.axes: unknown key"):
        build(Scenario, data, "f.yaml")


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.kind)
def test_every_kind_of_fault(fault):
    scenario = Scenario(faults=(fault, dataclasses.replace(fault, start_s=2.0, duration_s=0.5)))
    assert build(Scenario, as_mapping(scenario), "f.yaml") == scenario
    assert build(Scenario, {"faults": [{"kind": fault.kind}]}, "f.yaml").faults == (fault,)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.kind)
def test_numbers_of_faults_are_named_with_their_index(fault):
    for field in dataclasses.fields(fault):
        if "unit" not in field.metadata:
            continue
        default = getattr(fault, field.name)
        key = f"faults[1].{field.name}"
        if isinstance(default, tuple):
            key, value = f"{key}[0]", [math.nan, *default[1:]]
        else:
            value = field.metadata["high"] + 1
        data = {"faults": [{"kind": fault.kind}, {"kind": fault.kind, field.name: value}]}
        with pytest.raises(BadInput) as caught:
            build(Scenario, data, "f.yaml")
        assert str(caught.value).startswith(f"f.yaml: {key}: expected a")


@pytest.mark.parametrize(
    ("faults", "expected"),
    [
        ({"kind": "push"}, "faults: expected a list of mappings, got"),
        ("push", "faults: expected a list of mappings, got 'push'"),
        ([3], r"faults\[0\]: expected a mapping with a kind; valid: joint_degraded,"),
        ([{"kind": "push"}, {"start_s": 1}], r"faults\[1\]: expected a mapping with a kind"),
        ([{"kind": "pusch"}], r"faults\[0\].kind: unknown kind 'pusch'; did you mean 'push'"),
        ([{"kind": "push", "start": 1}], r"faults\[0\].start: unknown key; did you mean 'start_s'"),
        ([{"kind": "push"}] * 1001, "faults: expected at most 1000 items, got 1001"),
    ],
)
def test_invalid_faults_are_named(faults, expected):
    with pytest.raises(BadInput, match=f"f.yaml: {expected}"):
        build(Scenario, {"faults": faults}, "f.yaml")


def test_a_fault_is_active_from_its_start_until_before_its_end():
    fault = Push(start_s=0.1, duration_s=0.2)
    assert [bool(fault.is_active(t)) for t in (0.09, 0.1, 0.29, 0.3)] == [False, True, True, False]


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        ([0, 0], r"orientation.axis: expected a list of 3 numbers"),
        ([0, 0, 1e9], r"orientation.axis\[2\]: expected a number in \[-1000, 1000\], got 1"),
        ("down", r"orientation.axis: expected a list of 3 numbers"),
    ],
)
def test_an_invalid_axis_is_named(axis, expected):
    with pytest.raises(BadInput, match=expected):
        build(Scenario, {"orientation": {"kind": "fixed", "axis": axis}}, "f.yaml")


def test_an_empty_mapping_gives_the_defaults(scenario):
    assert scenario == build(Scenario, {}, "f.yaml")


def test_every_key_is_declared():
    """Numbers have a unit and a finite range; strings have choices or are files."""
    for _, key, field, value in LEAVES:
        if isinstance(value, str):
            assert key == "name" or field.metadata.keys() & {"options", "file"}, key
        elif not isinstance(value, bool) and key != "faults":
            low, high, length = (field.metadata[k] for k in ("low", "high", "length"))
            assert field.metadata["unit"] and math.isfinite(low) and math.isfinite(high), key
            assert low < high, key
            assert length in (None, len(value) if isinstance(value, tuple) else None), key


@pytest.mark.parametrize(
    "wrong", ["10 s", True, None, {"x": 1}, math.nan, math.inf, "below", "above"], ids=str
)
def test_numbers_out_of_type_or_range_are_named_with_unit_and_range(wrong):
    for reference, key, field, default in QUANTITIES:
        low, high, unit = (field.metadata[k] for k in ("low", "high", "unit"))
        value = low - 1 if wrong == "below" else high + 1 if wrong == "above" else wrong
        if isinstance(default, tuple):
            key, value = f"{key}[{len(default) - 1}]", [*default[:-1], value]
        message = refuses(reference, key.partition("[")[0], value)
        whole = "a whole number" if isinstance(default, int) else "a number"
        ending = "" if unit == "1" else f" {unit}"
        assert f": {key}: expected {whole} in [{low:.10g}, {high:.10g}]{ending}, got " in message


def test_lists_of_the_wrong_length_are_named():
    for reference, key, field, default in QUANTITIES:
        if field.metadata["length"]:
            for wrong in ([], [default[0]] * (len(default) + 1), default[0]):
                message = refuses(reference, key, wrong)
                assert f": {key}: expected a list of {len(default)} numbers" in message


def test_choices_are_listed():
    for reference, key, field, default in LEAVES:
        if options := field.metadata.get("options"):
            message = refuses(reference, key, f"{default}z")
            assert f"did you mean '{default}'?" in message
            assert all(option in message for option in options)
            refuses(reference, key, 3)


@pytest.mark.parametrize("reference", KINDS, ids=lambda kind: kind.kind)
def test_unknown_keys_are_named_on_every_level(reference):
    for prefix, names in sections(Scenario(reference=reference)):
        for name in names:
            wrong = f"{prefix}{name}x"
            message = refuses(reference, wrong, 1.0)
            assert f": {wrong}: unknown key; did you mean '{name}'? (valid: " in message

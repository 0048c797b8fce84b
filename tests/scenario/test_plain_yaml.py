"""Types of plain YAML values, and errors with their key."""

import math

import hypothesis.strategies as st
import pytest
import yaml
from hypothesis import given

from aerodrake.scenario.plain_yaml import MAX_DEPTH, MAX_VALUES, dump, dump_line, parse
from aerodrake.support.errors import ScenarioError


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("7", 7), ("-3", -3), ("+3", 3), ("0", 0), ("0.50", 0.5), ("-.5", -0.5), ("1.", 1.0),
        ("1e-3", 1e-3), ("1E3", 1e3), ("-.inf", -math.inf), ("9" * 30, 1e30), ("1e999", math.inf),
        ("true", True), ("False", False), ("~", None), ("null", None), ("", None),
    ],
)  # fmt: skip
def test_plain_numbers_and_booleans(text, value):
    parsed = parse(text, "f.yaml")
    assert parsed == value and type(parsed) is type(value)


@pytest.mark.parametrize(
    "text",
    ["010", "08", "1:30", "1:30.5", "0x1F", "0b11", "0o17", "1_000", "off", "no", "Yes", "y",
     "2020-01-01", "2020-13-45", "=", "<<", "1 m", "1,5", "١٢", ".e3", "1e", "--1", "NaN", "inf"],
)  # fmt: skip
def test_other_types_of_yaml_1_1_are_strings(text):
    """A field that expects a number then refuses the value as written."""
    assert parse(text, "f.yaml") == text


def test_quoted_values_are_strings():
    assert parse("['5', \"true\"]", "f.yaml") == ["5", "true"]


@pytest.mark.parametrize(
    ("text", "key", "problem"),
    [
        ("mpc:\n  k_e: &a [1]\n", "mpc.k_e", "line 2: expected a value without anchors"),
        ("mpc:\n  k_e: *a\n", "mpc.k_e", "line 2: expected a value without anchors"),
        ("mpc: {k_e: [1, !!float 2]}", "mpc.k_e[1]", "line 1: expected a value without a tag"),
        ("a: !!python/object/apply:os.system [true]", "a", "tag:yaml.org,2002:python/object"),
        ("a: {b: 1, c: 2, b: 3}", "a.b", "line 1: expected each key once"),
        ("a: {3: 1}", "a", "line 1: expected a name as key, got 3"),
        ("a:\n  ? [b]\n  : 1\n", "a", "line 2: expected a name as key"),
        ("a:\n- 1\n- [2\n", "a[1]", "expected YAML; line "),
        ("a: b: c", "", "expected YAML; line 1: mapping values are not allowed here"),
        ('a: "\\U99999999"', "", "expected YAML; line 1: "),
        ("a: 1\nb: \x07", "", "expected YAML; line 2: special characters are not allowed"),
        ("a: 1\n---\nb: 1\n", "", "expected YAML; line 2"),
        ("a: " + "[" * (MAX_DEPTH + 1), "a" + "[0]" * (MAX_DEPTH - 1), "more than 10 levels"),
        ("a: [" + "1," * MAX_VALUES + "1]", f"a[{MAX_VALUES - 3}]", "more than 10000 val"),
    ],
)  # fmt: skip
def test_errors_have_the_key(text, key, problem):
    with pytest.raises(ScenarioError) as caught:
        parse(text, "f.yaml")
    assert (caught.value.source, caught.value.key) == ("f.yaml", key)
    assert problem in str(caught.value)
    with pytest.raises(ScenarioError) as caught:
        parse(text, "--set", "outer")
    assert caught.value.key in (f"outer.{key}".rstrip("."), "outer")


values = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**17), 10**17) | st.floats(allow_nan=False)
    | st.text(st.characters(exclude_categories=["C"])) | st.from_regex(r"[-+0-9:._xeE]{1,6}"),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("ab1~", min_size=1), inner),
    max_leaves=6,
)  # fmt: skip


@given(values)
def test_written_values_are_read_back_by_yaml_1_1_and_1_2(value):
    text = dump(value)
    assert parse(text, "f.yaml") == value
    assert yaml.safe_load(text) == value


numbers = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**17), 10**17)
words = st.text().filter(str.isprintable) | st.sampled_from(["off", "1e3", "0x1", "true", "~"])


@given(numbers | words | st.booleans() | st.lists(numbers))
def test_a_value_on_one_line_is_read_back_exactly(value):
    """The value is alone, as with --set, or in a list."""
    line = dump_line(value)
    assert "\n" not in line
    for again in (parse(line, "here"), parse(f"[{line}, 1]", "here")[0]):
        assert again == value and type(again) is type(value)


def test_words_have_quotes_only_if_necessary():
    assert dump_line("package://aerodrake/a.urdf") == "package://aerodrake/a.urdf"
    assert (dump_line("clik"), dump_line("true"), dump_line("a, b")) == ("clik", '"true"', '"a, b"')

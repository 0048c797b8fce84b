"""Messages of errors are one short line."""

import pickle

import pytest

from aerodrake.support.errors import BadInput, ScenarioError, file_at, nearest


def test_names_source_and_key_in_one_line():
    assert str(BadInput("a.yaml", "mpc.horizon", "expected\n  2")) == (
        "a.yaml: mpc.horizon: expected 2"
    )
    assert str(BadInput("a.yaml", "", "expected UTF-8")) == "a.yaml: expected UTF-8"


@pytest.mark.parametrize(
    "hostile",
    ["k" * 1_000_000, "a\nb\r\nc", "\x1b[31mred\x1b[0m\x07"],
    ids=["long", "lines", "escapes"],
)
@pytest.mark.parametrize("part", range(3))
def test_the_message_is_short_and_printable_for_any_input(hostile, part):
    parts = ["a.yaml", "key", "message"]
    parts[part] = hostile
    message = str(BadInput(*parts))
    assert len(message) < 2000
    assert message.isprintable()


def test_pickling_preserves_the_message():
    error = BadInput("a.yaml", "mpc.horizon", "expected 2")
    assert str(pickle.loads(pickle.dumps(error))) == "a.yaml: mpc.horizon: expected 2"


def test_nearest_names_the_closest_and_all_valid_names():
    assert nearest("horizn", ["k_e", "horizon"]) == (
        "did you mean 'horizon'? (valid: horizon, k_e)"
    )
    assert nearest("zzz", ["k_e", "horizon"]) == "valid: horizon, k_e"
    assert nearest(3, ["k_e"]) == "valid: k_e"


def test_an_error_in_a_file_names_the_key_of_the_scenario():
    with pytest.raises(ScenarioError) as caught, file_at("a.yaml", "reference.file"):
        raise BadInput("b.csv", "", "expected 2 rows")
    assert (caught.value.source, caught.value.key) == ("a.yaml", "reference.file")
    assert str(caught.value) == "a.yaml: reference.file: b.csv: expected 2 rows"
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is ScenarioError and str(again) == str(caught.value)
    with pytest.raises(ScenarioError, match="^other: key: wrong$"), file_at("a.yaml", "file"):
        raise ScenarioError("other", "key", "wrong")
